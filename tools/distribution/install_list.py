# SPDX-License-Identifier: Apache-2.0
"""The list ``install.txt``: every package of an installation with the hash of its file."""

import hashlib
from collections.abc import Iterable, Mapping
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

_HEAD = """\
# Made by make wheels: all that an installation without compiler needs, with hashes.
#   python3 -m venv rocsafe && rocsafe/bin/pip install -r install.txt
--find-links .
--require-hashes
"""


def install_list(
    wheels: Iterable[Path], requirements: Iterable[str], lock: Mapping[str, str]
) -> str:
    """Return the text of the list.

    Parameters
    ----------
    wheels
        Of this suite.
    requirements
        What they need of the package index.
    lock
        Lines of ``requirements/lock.txt`` by package.
    """
    own = [f'{_requirement(path)} --hash=sha256:{_digest(path)}' for path in sorted(wheels)]
    foreign = [lock[name] for name in sorted(_closure(requirements))]
    return '\n'.join([_HEAD.rstrip('\n'), *own, *foreign]) + '\n'


def _requirement(wheel: Path) -> str:
    name, version = wheel.name.split('-')[:2]
    return f'{name}=={version}'


def _digest(wheel: Path) -> str:
    return hashlib.sha256(wheel.read_bytes()).hexdigest()


def _closure(requirements: Iterable[str]) -> set[str]:
    """Return the names of what is needed, directly or not, by the metadata installed here."""
    waiting = [Requirement(line) for line in requirements]
    found: set[str] = set()
    while waiting:
        requirement = waiting.pop()
        name = canonicalize_name(requirement.name)
        if name in found:
            continue
        found.add(name)
        needs = [Requirement(line) for line in metadata.requires(name) or ()]
        extras = requirement.extras or {''}
        waiting += [
            need
            for need in needs
            if need.marker is None or any(need.marker.evaluate({'extra': x}) for x in extras)
        ]
    return found
