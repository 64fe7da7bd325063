# SPDX-License-Identifier: Apache-2.0
"""Checks of the machine: a complete Python, a compiler, CMake, space on the disk."""

import json
import os
import platform
import re
import shutil
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from workspace.errors import SetupError

PYTHON_VERSIONS = ((3, 10), (3, 11), (3, 12))
CMAKE_MINIMUM = (3, 21)
# Measured: 0.7 GB for the virtual environment, 0.1 GB for the build; the rest for pip's cache.
DISK_NEEDED_BYTES = 1_500_000_000
PROBE_LIMIT_S = 20.0

_PROBE = """
import importlib.util, json, os, sys, sysconfig
print(json.dumps({
    'executable': sys.executable,
    'version': sys.version_info[:3],
    'lacks': [name for name in ('venv', 'ensurepip') if importlib.util.find_spec(name) is None],
    'headers': os.path.exists(os.path.join(sysconfig.get_path('include'), 'Python.h')),
}))
"""


@dataclass(frozen=True)
class BasePython:
    """A Python of the machine, described by its own output."""

    executable: Path
    version: tuple[int, int, int]
    lacks: tuple[str, ...]
    has_headers: bool

    @property
    def minor(self) -> tuple[int, int]:
        """Version without the patch level."""
        return self.version[:2]

    @property
    def name(self) -> str:
        """Version as text."""
        return '.'.join(str(part) for part in self.version)

    def complaint(self) -> str:
        """Return what it lacks and how to install that; empty if nothing."""
        package = f'python{self.minor[0]}.{self.minor[1]}'
        if self.lacks:
            return _complaint(self, f'module {self.lacks[0]}', f'{package}-venv')
        if not self.has_headers:
            return _complaint(self, 'Python.h, to compile the messages', f'{package}-dev')
        return ''


def choose_python(
    environment: Mapping[str, str], wanted: tuple[int, int] | None, venv: Path
) -> BasePython:
    """Return the first Python that is complete: ``PYTHON``, else those on the PATH.

    Parameters
    ----------
    environment
        Of the user.
    wanted
        The only version that will do, None if any that ROCSAFE supports will.
    venv
        Virtual environment that is about to be made, so nothing in it is taken.

    Raises
    ------
    SetupError
        If there is none, saying what the best one lacks.
    """
    versions = (wanted,) if wanted else PYTHON_VERSIONS
    best = None
    for command in _candidates(environment, versions, venv):
        python = probe(command)
        if python is None or python.minor not in versions:
            continue
        if not python.complaint():
            return python
        best = best or python
    if best is not None:
        raise SetupError(best.complaint())
    names = ' or '.join('.'.join(map(str, version)) for version in versions)
    reason = ', for which the sourced rclpy was built,' if wanted else ''
    raise SetupError(
        f'no Python {names}{reason} on the PATH; on Debian or Ubuntu: '
        'sudo apt install python3 python3-venv python3-dev'
    )


def probe(command: str) -> BasePython | None:
    """Ask the Python `command` about itself; None if it does not start."""
    try:
        answer = subprocess.run(
            [command, '-I', '-S', '-B', '-c', _PROBE],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=PROBE_LIMIT_S,
            check=True,
        )
        facts = json.loads(answer.stdout)
    except (OSError, ValueError, subprocess.SubprocessError):
        return None
    return BasePython(
        executable=Path(facts['executable']),
        version=tuple(facts['version']),
        lacks=tuple(facts['lacks']),
        has_headers=facts['headers'],
    )


def check_tools(path: str) -> None:
    """Check the programs that a build needs.

    Raises
    ------
    SetupError
        Naming every one that is missing, why it is needed and its Debian package.
    """
    needs = (
        ('g++', 'compiles the messages', 'g++'),
        ('make', 'runs the compiler', 'make'),
        ('cmake', 'configures the build', 'cmake'),
        ('git', 'gives each run its revision', 'git'),
        ('bash', 'reads the environment of the build', 'bash'),
    )
    missing = [need for need in needs if not shutil.which(need[0], path=path)]
    if missing:
        raise SetupError(
            'missing: '
            + ', '.join(f'{name} ({reason})' for name, reason, _ in missing)
            + '; on Debian or Ubuntu: sudo apt install '
            + ' '.join(package for *_, package in missing)
        )
    _check_cmake(path)


def _check_cmake(path: str) -> None:
    cmake = shutil.which('cmake', path=path) or 'cmake'
    try:
        answer = subprocess.run(
            [cmake, '--version'],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=PROBE_LIMIT_S,
            check=False,
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise SetupError(f'{cmake} does not start: {error}') from error
    match = re.search(r'version (\d+)\.(\d+)', answer.stdout)
    if match is None or tuple(map(int, match.groups())) < CMAKE_MINIMUM:
        found = match.group() if match else 'no version'
        raise SetupError(
            f'{cmake} is {found}, 3.21 or newer is needed; Debian 12 and Ubuntu 22.04 or newer '
            'have it: sudo apt install cmake'
        )


def check_wheels_exist() -> None:
    """Check that there are wheels of ROS 2 for this kind of machine.

    Raises
    ------
    SetupError
        If it does not.
    """
    system, processor = platform.system(), platform.machine()
    if (system, processor) != ('Linux', 'x86_64'):
        raise SetupError(
            f'ROS 2 has no wheels for {system} on {processor}: install ROS 2 Jazzy from its '
            'distribution packages and source /opt/ros/jazzy/setup.bash first'
        )


def check_disk(folder: Path) -> None:
    """Check that the disk has space for a first set-up.

    Raises
    ------
    SetupError
        If less than `DISK_NEEDED_BYTES` is free.
    """
    free = shutil.disk_usage(folder).free
    if free < DISK_NEEDED_BYTES:
        raise SetupError(
            f'{free / 1e9:.1f} GB is free in {folder}, '
            f'a set-up needs {DISK_NEEDED_BYTES / 1e9:.1f} GB'
        )


def _complaint(python: BasePython, lacking: str, package: str) -> str:
    return (
        f'{python.executable} (Python {python.name}) lacks {lacking}; '
        f'on Debian or Ubuntu: sudo apt install {package}'
    )


def _candidates(
    environment: Mapping[str, str], versions: tuple[tuple[int, int], ...], venv: Path
) -> Iterator[str]:
    if environment.get('PYTHON'):
        yield environment['PYTHON']
        return
    active = environment.get('VIRTUAL_ENV')
    closed = [venv, *([Path(active)] if active else [])]
    names = ['python3', *(f'python{major}.{minor}' for major, minor in reversed(versions))]
    folders = [*environment.get('PATH', os.defpath).split(os.pathsep), '/usr/bin']
    for name in names:
        for folder in folders:
            command = Path(folder) / name
            if folder and os.access(command, os.X_OK) and not _within(command, closed):
                yield str(command)


def _within(command: Path, folders: list[Path]) -> bool:
    return any(command.is_relative_to(folder) for folder in folders)
