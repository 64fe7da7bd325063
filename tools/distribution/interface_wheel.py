# SPDX-License-Identifier: Apache-2.0
"""Wheels of the packages of interfaces: what colcon installed, without what only builds need."""

import sysconfig
from collections.abc import Iterator, Sequence
from pathlib import Path

from distribution.archive import Member, write_wheel

_LIBRARIES = ('rosidl_generator_c', 'rosidl_generator_py', 'rosidl_typesupport_c',
              'rosidl_typesupport_fastrtps_c', 'rosidl_typesupport_introspection_c')  # fmt: skip
_SHARED = ('msg', 'srv', 'action')
_METADATA = """\
Metadata-Version: 2.1
Name: {name}
Version: {version}
Summary: Interfaces of ROCSAFE, built for ROS 2 Jazzy from wheels
License: Apache-2.0
"""
_WHEEL = """\
Wheel-Version: 1.0
Generator: rocsafe
Root-Is-Purelib: false
Tag: {tag}
"""


def make_interface_wheel(
    prefix: Path, name: str, version: str, requirements: Sequence[str], out: Path
) -> Path:
    """Write the wheel of a package that colcon installed below `prefix`; return its path.

    Raises
    ------
    FileNotFoundError
        If a library is missing there.
    """
    info = f'{name}-{version}.dist-info'
    tag = _tag()
    members = {
        **dict(_python_files(prefix, name)),
        **{f'{name}-{version}.data/data/{to}': Member(content=file.read_bytes())
           for to, file in _data_files(prefix, name)},
        f'{info}/METADATA': Member(content=_metadata(name, version, requirements).encode()),
        f'{info}/WHEEL': Member(content=_WHEEL.format(tag=tag).encode()),
    }  # fmt: skip
    path = out / f'{name}-{version}-{tag}.whl'
    write_wheel(path, info, members)
    return path


def _tag() -> str:
    """Return the tag of this Python on this kind of machine."""
    python = sysconfig.get_config_var('py_version_nodot')
    return f'cp{python}-cp{python}-{sysconfig.get_platform().replace("-", "_")}'


def _metadata(name: str, version: str, requirements: Sequence[str]) -> str:
    lines = [f'Requires-Dist: {requirement}\n' for requirement in requirements]
    return _METADATA.format(name=name, version=version) + ''.join(lines)


def _python_files(prefix: Path, name: str) -> Iterator[tuple[str, Member]]:
    site = next(prefix.glob(f'lib/python3*/site-packages/{name}')).parent
    for path in sorted((site / name).rglob('*')):
        if path.suffix in {'.py', '.so'}:
            mode = 0o755 if path.suffix == '.so' else 0o644
            yield str(path.relative_to(site)), Member(content=path.read_bytes(), mode=mode)


def _data_files(prefix: Path, name: str) -> Iterator[tuple[str, Path]]:
    """Yield where each file belongs below the prefix of an environment, and where it is."""
    for kind in _LIBRARIES:
        library = Path('lib', f'lib{name}__{kind}.so')
        yield str(library), prefix / library
    share = prefix / 'share' / name
    files = [share / 'package.xml']
    files += [path for kind in _SHARED for path in (share / kind).rglob('*') if path.is_file()]
    index = prefix / 'share/ament_index/resource_index'
    files += [index / kind / name for kind in ('packages', 'rosidl_interfaces')]
    for file in sorted(files):
        yield str(file.relative_to(prefix)), file
