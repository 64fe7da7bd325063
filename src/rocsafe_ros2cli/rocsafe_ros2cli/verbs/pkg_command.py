# SPDX-License-Identifier: Apache-2.0
"""`ros2 pkg`."""

from argparse import Namespace

from rocsafe_ros2cli.command import Verb, argument
from rocsafe_ros2cli.packages import executables, package_names


def _executables(options: Namespace) -> None:
    """List the executables of a package, or of all packages."""
    named = options.package_name
    for package in package_names() if named is None else [named]:
        for path in executables(package):
            print(f'{package} {path.name}')


VERBS = (
    Verb(
        name='executables',
        summary='Output a list of package specific executables',
        arguments=(argument('package_name', nargs='?', help='The package name'),),
        run=_executables,
    ),
)
