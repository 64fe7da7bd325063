# SPDX-License-Identifier: Apache-2.0
"""Every `rocsafe` command in the documents is one that there is, with options that it has."""

import re
import shutil
import subprocess
from functools import lru_cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [
    ROOT / 'README.md', ROOT / 'SECURITY.md', ROOT / 'CONTRIBUTING.md',
    *sorted((ROOT / 'docs').rglob('*.md')), *sorted((ROOT / 'src').glob('*/README.md')),
]  # fmt: skip
# A command stands on a line of code of its own, or between backquotes; a remark may follow.
_BLOCK = re.compile(r'^ {4,}(?:\$ |nice [-\w ]+)?(?:\S*/)?(rocsafe .*)$', re.M)
_INLINE = re.compile(r'`(rocsafe\s[^`]+)`')
_OPTION = re.compile(r'(?<![\w-])(--[a-z][\w-]*)')
LIMIT_S = 240.0


def commands_of(document: Path) -> list[str]:
    """Return the commands of a document, continued lines joined, remarks left out."""
    text = document.read_text().replace('\\\n', ' ')
    found = [*_BLOCK.findall(text), *(' '.join(one.split()) for one in _INLINE.findall(text))]
    # Two spaces or a hash begin a remark.
    return [re.split(r'\s{2,}|\s#|[|&;>]', one)[0] for one in found]


def wanted() -> dict[str, dict[str, str]]:
    """Return each command that a document names: its options, each with where it stands."""
    found: dict[str, dict[str, str]] = {}
    for document in DOCUMENTS:
        for one in commands_of(document):
            word = one.split()[1]
            if re.fullmatch(r'[a-z][\w-]*', word):
                options = found.setdefault(word, {})
                for option in _OPTION.findall(one):
                    options[option] = f'{document.relative_to(ROOT)}: {one}'
    return found


@lru_cache(maxsize=64)
def help_of(*words: str) -> str:
    """Return what a command prints of itself."""
    command = [shutil.which('rocsafe') or 'rocsafe', *words, '--help']
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=LIMIT_S, check=False, env=None
    )
    return done.stdout if done.returncode == 0 else ''


def test_commands_are_found_in_the_documents():
    """What is looked at below is not nothing."""
    found = wanted()
    assert {'run', 'check', 'plan', 'map', 'localize', 'console', 'verify'} <= found.keys()
    assert '--public-key' in found['verify']


@pytest.mark.all
@pytest.mark.parametrize('word', sorted(wanted()))
def test_every_option_in_the_documents_is_one_of_its_command(word):
    """As the command's own help lists them, with those of its words, such as `scene render`."""
    text = help_of(word)
    assert text, f'rocsafe {word}: there is no such command'
    missing = {}
    for option, where in wanted()[word].items():
        # A command may have words of its own, such as `scene render`.
        further = re.match(r'\S+ +([a-z]+)\b', where.partition('rocsafe ')[2])
        whole = text + (help_of(word, further[1]) if further and further[1] in text else '')
        if not re.search(rf'(?<![\w-]){option}(?![\w-])', whole):
            missing[option] = where
    assert missing == {}
