# SPDX-License-Identifier: Apache-2.0
"""The wheel `rocsafe`: it needs all others, and brings the commands and the configuration."""

from collections.abc import Sequence
from pathlib import Path

from distribution.archive import Member, write_wheel

NAME = 'rocsafe'
_METADATA = """\
Metadata-Version: 2.1
Name: rocsafe
Version: {version}
Summary: Surveys dangerous places with unmanned vehicles: ROS 2 node suite
License: Apache-2.0
Requires-Python: >=3.10,<3.13
"""
_WHEEL = """\
Wheel-Version: 1.0
Generator: rocsafe
Root-Is-Purelib: true
Tag: py3-none-any
"""
# pip puts the interpreter of the environment into the first line. ROS looks for packages and
# definitions of messages below the prefixes of AMENT_PREFIX_PATH.
_HEAD = """\
#!python
import os
import sys

known = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
prefixes = dict.fromkeys([sys.prefix, *filter(None, known)])
os.environ['AMENT_PREFIX_PATH'] = os.pathsep.join(prefixes)
"""
_ROCSAFE = """\

from rocsafe_orchestrator.cli import main

if __name__ == '__main__':
    sys.exit(main())
"""
_ROS2 = """\
# A real ros2 on the PATH is never shadowed.
own = os.path.join(sys.prefix, 'bin')
for folder in os.get_exec_path():
    command = os.path.join(folder, 'ros2')
    if os.path.realpath(folder) != os.path.realpath(own) and os.access(command, os.X_OK):
        os.execv(command, [command, *sys.argv[1:]])

from rocsafe_ros2cli.__main__ import main

if __name__ == '__main__':
    sys.exit(main())
"""


def make_suite_wheel(version: str, requirements: Sequence[str], config: Path, out: Path) -> Path:
    """Write the wheel to the folder `out`; return its path.

    Parameters
    ----------
    version
        Of the suite.
    requirements
        All its wheels.
    config
        Folder of scenarios and scenes, which goes to ``share/rocsafe/config``.
    out
        Folder of the wheels.
    """
    info, data = f'{NAME}-{version}.dist-info', f'{NAME}-{version}.data'
    needs = ''.join(f'Requires-Dist: {requirement}\n' for requirement in requirements)
    files = [path for path in sorted(config.rglob('*')) if path.is_file()]
    members = {
        f'{data}/data/share/rocsafe/config/{path.relative_to(config)}': Member(
            content=path.read_bytes()
        )
        for path in files
    }
    for name, text in (('rocsafe', _ROCSAFE), ('ros2', _ROS2)):
        members[f'{data}/scripts/{name}'] = Member(content=(_HEAD + text).encode(), mode=0o755)
    metadata = _METADATA.format(version=version) + needs
    members[f'{info}/METADATA'] = Member(content=metadata.encode())
    members[f'{info}/WHEEL'] = Member(content=_WHEEL.encode())
    path = out / f'{NAME}-{version}-py3-none-any.whl'
    write_wheel(path, info, members)
    return path
