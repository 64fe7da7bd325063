# SPDX-License-Identifier: Apache-2.0
"""The wheels of the libraries: those of the package index, by the hashes of the lock."""

import subprocess
import sys
import tempfile
from collections.abc import Iterable
from importlib import metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name


class LibrariesError(RuntimeError):
    """The libraries could not be fetched."""


def closure(requirements: Iterable[str]) -> set[str]:
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


def gather(lines: Iterable[str], out: Path) -> None:
    """Write the wheel of each line of a lock to a folder; what has none is made into one.

    Raises
    ------
    LibrariesError
        With the last line that pip says, if a file cannot be had or has another hash.
    """
    with tempfile.NamedTemporaryFile('w', suffix='.txt') as wanted:
        wanted.write('\n'.join(lines))
        wanted.flush()
        command = [sys.executable, '-m', 'pip', 'wheel', '-q', '--no-deps', '--require-hashes']
        command += ['--prefer-binary', '-w', str(out), '-r', wanted.name]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode:
        errors = [line for line in done.stderr.splitlines() if line.startswith('ERROR')]
        raise LibrariesError((errors or done.stderr.splitlines() or ['pip failed'])[-1])
