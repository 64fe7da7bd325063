# SPDX-License-Identifier: Apache-2.0
"""A command goes on when nobody reads its output any more."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rocsafe_orchestrator.processes.lasting_output import LastingStream, lasting_output

# Says more than a pipe holds, and ends with a code of its own.
TALKER = """
import sys
from rocsafe_orchestrator.processes.lasting_output import lasting_output
from rich.console import Console
with lasting_output():
    console = Console()
    for number in range(300):
        console.print(number, 1000 * 'x', highlight=False)
        print('complaint', file=sys.stderr)
sys.exit(7)
"""


def test_reader_that_leaves_ends_nothing() -> None:
    """As with `| head -1`: no traceback, and the exit code of the work."""
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path))}
    command = [sys.executable, '-c', TALKER]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        process.stdout.close()
        assert process.wait(timeout=60.0) == 7


def test_output_that_is_closed_from_the_begin_ends_nothing() -> None:
    """As under a service manager: the exit code is that of the work."""
    environment = {**os.environ, 'PYTHONPATH': os.pathsep.join(filter(None, sys.path))}
    shell = ['sh', '-c', 'exec "$0" -c "$1" 0<&- >&- 2>&-', sys.executable, TALKER]
    assert subprocess.run(shell, env=environment, timeout=60.0, check=False).returncode == 7


@pytest.mark.skipif(not Path('/dev/full').exists(), reason='no /dev/full here')
def test_full_disk_under_the_output_is_passed_over() -> None:
    """What cannot be written is not shown."""
    with Path('/dev/full').open('w', encoding='utf-8') as full:
        stream = LastingStream(full)
        stream.write('x' * 100_000)
        stream.flush()


def test_streams_come_back(capsys: pytest.CaptureFixture[str]) -> None:
    """What is written in the block arrives, and the streams are those of before."""
    before = sys.stdout, sys.stderr
    with lasting_output():
        sys.stdout.write('one\n')
        sys.stderr.write('two\n')
    assert (sys.stdout, sys.stderr) == before
    assert capsys.readouterr() == ('one\n', 'two\n')


def test_letters_that_a_terminal_does_not_have_are_escaped(tmp_path: Path) -> None:
    """A path with an umlaut in an ASCII terminal is no traceback."""
    path = tmp_path / 'terminal'
    with path.open('w', encoding='ascii') as ascii_only:
        LastingStream(ascii_only).write('run \xfc\u20ac\n')
    assert path.read_text(encoding='ascii') == 'run \\xfc\\u20ac\n'
