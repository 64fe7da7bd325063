# SPDX-License-Identifier: Apache-2.0
"""The list ``install.txt``: every package of an installation with the hash of its file."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

_HEAD = """\
# Made by make wheels: all that an installation needs, in this folder, with hashes.
#   python3 -m venv rocsafe && rocsafe/bin/pip install --no-compile -r install.txt
--no-index
--find-links .
--require-hashes
"""


def install_list(wheels: Iterable[Path]) -> str:
    """Return the text of the list for the wheels of a folder."""
    lines = [f'{_requirement(path)} --hash=sha256:{_digest(path)}' for path in sorted(wheels)]
    return '\n'.join([_HEAD.rstrip('\n'), *lines]) + '\n'


def _requirement(wheel: Path) -> str:
    name, version = wheel.name.split('-')[:2]
    return f'{name}=={version}'


def _digest(wheel: Path) -> str:
    return hashlib.sha256(wheel.read_bytes()).hexdigest()
