# SPDX-License-Identifier: Apache-2.0
"""`ros2 pkg`."""

from argparse import ArgumentParser, Namespace

from rocsafe_ros2cli.command import Command, CommandError, Verb
from rocsafe_ros2cli.packages import executables, package_names, package_prefix


def _add_executables_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `executables`."""
    parser.add_argument('package_name', nargs='?', help='The package name')
    parser.add_argument('--full-path', action='store_true', help='Show full paths')


def _executables(options: Namespace) -> int:
    """List the executables of a package, or of all."""
    named = options.package_name
    for package in package_names() if named is None else [named]:
        for path in executables(package):
            print(path if options.full_path else f'{package} {path.name}')
    return 0


def _list(_options: Namespace) -> int:
    """List packages."""
    for name in package_names():
        print(name)
    return 0


def _add_prefix_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `prefix`."""
    parser.add_argument('package_name', help='The package name')
    parser.add_argument('--share', action='store_true', help='Show the share folder')


def _prefix(options: Namespace) -> int:
    """Print where a package is installed."""
    try:
        prefix = package_prefix(options.package_name)
    except CommandError as error:
        raise CommandError('Package not found') from error
    print(prefix / 'share' / options.package_name if options.share else prefix)
    return 0


COMMAND = Command(
    verbs=(
        Verb(
            name='executables',
            summary='Output a list of package specific executables',
            add_arguments=_add_executables_arguments,
            run=_executables,
        ),
        Verb(name='list', summary='Output a list of available packages', run=_list),
        Verb(
            name='prefix',
            summary='Output the prefix path of a package',
            add_arguments=_add_prefix_arguments,
            run=_prefix,
        ),
    )
)
