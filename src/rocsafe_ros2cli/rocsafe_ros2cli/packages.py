# SPDX-License-Identifier: Apache-2.0
"""Packages and their executables, as found in `AMENT_PREFIX_PATH`."""

import os
from pathlib import Path

from ament_index_python import PackageNotFoundError, get_package_prefix, get_packages_with_prefixes

from rocsafe_ros2cli.command import CommandError


def package_names() -> list[str]:
    """Return the names of all packages, in order."""
    return sorted(get_packages_with_prefixes())


def executables(package: str) -> list[Path]:
    """Return the executables below `lib/<package>`, in order, without those in hidden folders.

    Raises
    ------
    CommandError
        If there is no such package.
    """
    try:
        prefix = Path(get_package_prefix(package))
    except (PackageNotFoundError, ValueError) as error:
        raise CommandError(f"Package '{package}' not found") from error
    found = []
    for folder, folders, names in os.walk(prefix / 'lib' / package):
        folders[:] = [name for name in folders if not name.startswith('.')]
        paths = (Path(folder) / name for name in names)
        found += [path for path in paths if os.access(path, os.X_OK)]
    return sorted(found)


def executable(package: str, name: str) -> Path:
    """Return the executable of this name.

    Raises
    ------
    CommandError
        If there is no such package, or it has none or several of this name.
    """
    found = [path for path in executables(package) if path.name == name]
    if not found:
        raise CommandError('No executable found')
    if len(found) > 1:
        raise CommandError('\n- '.join(['Multiple executables found:', *map(str, found)]))
    return found[0]
