# SPDX-License-Identifier: Apache-2.0
"""Which ROS the workspace stands on: that of the system when one is sourced, else wheels."""

import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workspace.errors import SetupError

DISTRO = 'jazzy'
_EXTENSION_PATTERN = 'lib/python3*/site-packages/rclpy'


@dataclass(frozen=True)
class SystemRos:
    """A sourced ROS 2 installation.

    Attributes
    ----------
    rclpy
        Folder of its rclpy package.
    python_version
        The Python that rclpy was built for, such as (3, 12).
    prefixes
        Of AMENT_PREFIX_PATH, without those inside the checkout.
    """

    rclpy: Path
    python_version: tuple[int, int]
    prefixes: tuple[Path, ...]


def find_system_ros(environment: Mapping[str, str], root: Path) -> SystemRos | None:
    """Return the ROS that is sourced, or None on a machine that needs the wheels.

    Raises
    ------
    SetupError
        If another distribution is sourced, or this one only in part.
    """
    distro = environment.get('ROS_DISTRO', '')
    if not distro:
        return None
    if distro != DISTRO:
        raise SetupError(
            f'ROS_DISTRO={distro} is sourced, ROCSAFE needs {DISTRO}: open a shell without it, '
            f'or source /opt/ros/{DISTRO}/setup.bash'
        )
    entries = [
        Path(entry) for entry in environment.get('AMENT_PREFIX_PATH', '').split(':') if entry
    ]
    prefixes = tuple(entry for entry in entries if not entry.is_relative_to(root))
    for prefix in prefixes:
        for rclpy in sorted(prefix.glob(_EXTENSION_PATTERN)):
            return SystemRos(rclpy=rclpy, python_version=_built_for(rclpy), prefixes=prefixes)
    raise SetupError(
        f'ROS_DISTRO={distro} is set but no prefix in AMENT_PREFIX_PATH holds rclpy: '
        f'source /opt/ros/{DISTRO}/setup.bash, or unset ROS_DISTRO to use wheels'
    )


def _built_for(rclpy: Path) -> tuple[int, int]:
    """Read the Python version from the name of the extension, else from that of the folder."""
    names = [path.name for path in rclpy.glob('_rclpy_pybind11.cpython-3*.so')]
    match = re.search(r'cpython-3(\d+)', names[0]) if names else None
    match = match or re.search(r'python3\.(\d+)', str(rclpy))
    if match is None:
        raise SetupError(f'cannot tell for which Python {rclpy} was built')
    return 3, int(match.group(1))


def missing_packages(sources: Path, prefixes: tuple[Path, ...]) -> list[str]:
    """Return the ROS packages that ours depend on and no prefix holds.

    Keys that start with ``python3-`` name libraries of the distribution, not ROS packages.
    """
    manifests = [ElementTree.parse(path).getroot() for path in sources.glob('*/package.xml')]  # noqa: S314
    ours = {str(manifest.findtext('name')).strip() for manifest in manifests}
    wanted = {
        str(element.text).strip()
        for manifest in manifests
        for kind in ('depend', 'buildtool_depend', 'build_depend', 'exec_depend')
        for element in manifest.findall(kind)
    }
    return sorted(
        name
        for name in wanted - ours
        if not name.startswith(('python3-', 'mcap-'))
        and not any(_holds(prefix, name) for prefix in prefixes)
    )


def _holds(prefix: Path, package: str) -> bool:
    return (prefix / 'share/ament_index/resource_index/packages' / package).exists()
