# SPDX-License-Identifier: Apache-2.0
"""`ros2 interface`."""

import sys
from argparse import ArgumentParser, Namespace

from rocsafe_ros2cli.command import Command, CommandError, Verb
from rocsafe_ros2cli.interface_text import definition_lines
from rocsafe_ros2cli.interfaces import interface_names

TITLES = {'msg': 'Messages', 'srv': 'Services', 'action': 'Actions'}


def _add_list_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `list`."""
    parser.add_argument('-m', '--only-msgs', action='store_true', help='Print only messages')
    parser.add_argument('-s', '--only-srvs', action='store_true', help='Print only services')
    parser.add_argument('-a', '--only-actions', action='store_true', help='Print only actions')


def _list(options: Namespace) -> int:
    """List the interfaces of this workspace and what it stands on."""
    wanted = {
        'msg': options.only_msgs,
        'srv': options.only_srvs,
        'action': options.only_actions,
    }
    for kind, title in TITLES.items():
        if wanted[kind] or not any(wanted.values()):
            print(f'{title}:')
            for name in interface_names(kind):
                print(f'    {name}')
    return 0


def _add_show_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `show`."""
    comments = parser.add_mutually_exclusive_group()
    comments.add_argument('--all-comments', action='store_true', help='Show nested comments too')
    comments.add_argument('--no-comments', action='store_true', help='Show no comments')
    parser.add_argument(
        'type', help="Interface (e.g. 'std_msgs/msg/String'), or '-' to read it from stdin"
    )


def _show(options: Namespace) -> int:
    """Print the definition of an interface, those of its fields below them."""
    name = sys.stdin.readline().strip() if options.type == '-' else options.type
    if not name:
        raise CommandError('the passed value is empty')
    for line in definition_lines(
        name, comments=not options.no_comments, nested_comments=options.all_comments
    ):
        print(line)
    return 0


COMMAND = Command(
    verbs=(
        Verb(
            name='list',
            summary='List all interface types available',
            add_arguments=_add_list_arguments,
            run=_list,
        ),
        Verb(
            name='show',
            summary='Output the interface definition',
            add_arguments=_add_show_arguments,
            run=_show,
        ),
    )
)
