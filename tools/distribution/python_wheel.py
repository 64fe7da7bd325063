# SPDX-License-Identifier: Apache-2.0
"""Wheels of the Python packages: what setuptools makes of them, completed for ROS.

setup.py tells colcon to put the executables into ``lib/<package>``, where `ros2 run` looks for
them. A wheel would have them all in ``bin``, where names such as ``import`` and ``map`` hide
other programs. They are therefore added here as files of ``lib/<package>``.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from configparser import ConfigParser
from pathlib import Path

from distribution.archive import Member, read_wheel, write_wheel

# pip would write an executable into bin for each entry of the group `console_scripts`.
EXECUTABLES = 'ros2_executables'
_BUILD = 'import sys; from setuptools import build_meta; build_meta.build_wheel(sys.argv[1])'
# A shell starts the Python of the environment that the file lies in; for Python, the second and
# third line are a string. pip writes interpreters with long paths in the same way.
_LAUNCHER = """\
#!/bin/sh
'''exec' "$(dirname -- "$0")/../../bin/python" "$0" "$@"
' '''
import sys

from {module} import {function}

if __name__ == '__main__':
    sys.exit({function}())
"""


def make_python_wheel(package: Path, requirements: Sequence[str], out: Path) -> Path:
    """Write the wheel of a package to the folder `out`; return its path."""
    with tempfile.TemporaryDirectory() as scratch:
        copy = Path(scratch, package.name)
        ignored = shutil.ignore_patterns('__pycache__', '*.egg-info', 'build')
        shutil.copytree(package, copy, ignore=ignored)
        made = _built(copy, Path(scratch))
        members = read_wheel(made)
        info = next(name for name in members if name.endswith('.dist-info/METADATA'))
        info = info.rpartition('/')[0]
        completed = _completed(members, info, package.name, requirements)
        completed |= dict(_machine_code(package))
        path = out / made.name
        write_wheel(path, info, completed)
    return path


def _built(package: Path, out: Path) -> Path:
    subprocess.run(
        [sys.executable, '-c', _BUILD, str(out)],
        cwd=package,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env={**os.environ, 'SOURCE_DATE_EPOCH': '315532800'},
        check=True,
    )
    return next(out.glob('*.whl'))


def _machine_code(package: Path) -> Iterator[tuple[str, Member]]:
    """Yield what set-up has compiled of the planner, for any processor of this kind."""
    for path in sorted((package / package.name).rglob('__pycache__/numba-*/*.nb[ci]')):
        yield str(path.relative_to(package)), Member(content=path.read_bytes())


def _completed(
    members: dict[str, Member], info: str, package: str, requirements: Sequence[str]
) -> dict[str, Member]:
    """Return the members with the requirements and the executables of `package`."""
    completed = dict(members)
    metadata = members[f'{info}/METADATA'].content.decode()
    completed[f'{info}/METADATA'] = Member(content=_with(metadata, requirements).encode())
    points = members.get(f'{info}/entry_points.txt')
    if points is None:
        return completed
    text = points.content.decode()
    renamed = text.replace('[console_scripts]', f'[{EXECUTABLES}]')
    completed[f'{info}/entry_points.txt'] = Member(content=renamed.encode())
    folder = f'{info.removesuffix(".dist-info")}.data/data/lib/{package}'
    for name, target in _entry_points(text):
        module, _, function = target.partition(':')
        launcher = _LAUNCHER.format(module=module, function=function)
        completed[f'{folder}/{name}'] = Member(content=launcher.encode(), mode=0o755)
    return completed


def _with(metadata: str, requirements: Sequence[str]) -> str:
    """Return the metadata with requirements after its other fields."""
    head, gap, description = metadata.partition('\n\n')
    lines = [f'Requires-Dist: {requirement}' for requirement in requirements]
    return '\n'.join([head.rstrip('\n'), *lines]) + (gap or '\n') + description


def _entry_points(text: str) -> list[tuple[str, str]]:
    parser = ConfigParser(delimiters=('=',))
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read_string(text)
    return parser.items('console_scripts') if parser.has_section('console_scripts') else []
