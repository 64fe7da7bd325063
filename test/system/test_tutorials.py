# SPDX-License-Identifier: Apache-2.0
"""The commands of the tutorials work as they are written, one after the other."""

import re
import subprocess
import textwrap
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TUTORIALS = ROOT / 'docs/tutorials'
LIMIT_S = 280.0
# Steps of a shell that a reader of the tutorial has open; others need his own files.
COMMAND = re.compile(r'^    ((?:rocsafe (?!.*READINGS\.csv)|RUN=).*)$', re.M)


def commands(tutorial: str) -> str:
    """Return the commands of a tutorial as a script."""
    return '\n'.join(COMMAND.findall((TUTORIALS / f'{tutorial}.md').read_text()))


@pytest.mark.all
@pytest.mark.system
@pytest.mark.parametrize(
    'tutorial', ['first-mission', 'your-place', 'gas-release', 'ground-vehicle']
)
def test_every_command_of_a_tutorial_works(tutorial, tmp_path, own_domain):
    """In a folder with the files of the tutorial and the scenarios of the repository."""
    (tmp_path / 'config').symlink_to(ROOT / 'config')
    text = (TUTORIALS / f'{tutorial}.md').read_text()
    for name, body in re.findall(r'`([\w.]+)`[^`]*```\w+\n(.*?)^```', text, re.M | re.S):
        (tmp_path / name).write_text(textwrap.dedent(body))
    script = commands(tutorial)
    assert script.count('rocsafe') > 1
    done = subprocess.run(
        ['bash', '-ec', script], cwd=tmp_path, capture_output=True, text=True, timeout=LIMIT_S,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
