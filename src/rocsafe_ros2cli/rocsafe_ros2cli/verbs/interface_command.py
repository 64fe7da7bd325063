# SPDX-License-Identifier: Apache-2.0
"""`ros2 interface`."""

from argparse import Namespace

from rocsafe_ros2cli.command import Verb, argument
from rocsafe_ros2cli.interfaces import definition_lines


def _show(options: Namespace) -> None:
    """Print the definition of an interface, those of its fields below them."""
    for line in definition_lines(options.type):
        print(line)


VERBS = (
    Verb(
        name='show',
        summary='Output the interface definition',
        arguments=(argument('type', help="Interface (e.g. 'std_msgs/msg/String')"),),
        run=_show,
    ),
)
