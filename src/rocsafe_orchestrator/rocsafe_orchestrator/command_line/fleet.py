# SPDX-License-Identifier: Apache-2.0
"""`rocsafe fleet`."""

import argparse

from rocsafe_orchestrator.command_line import Commands

VERBS = {
    'hold': 'stand still in the air',
    'resume': 'go on after a hold',
    'return': 'give up the route, fly home and land',
    'land': 'land where they are',
}


def add_to(commands: Commands) -> None:
    """Add the command to those of `rocsafe`."""
    text = (
        'Command all vehicles of the mission that is running in this ROS domain, or some of them. '
        'Prints the answer of each. Exit code 1 if one has not obeyed.'
    )
    parser = commands.add_parser('fleet', help='command all vehicles at once', description=text)
    words = '; '.join(f'{verb}: {what}' for verb, what in VERBS.items())
    parser.add_argument('verb', choices=VERBS, metavar='VERB', help=words)
    parser.add_argument('vehicles', nargs='*', metavar='VEHICLE', help='only these (default: all)')
    parser.set_defaults(command=_fleet)


def _fleet(arguments: argparse.Namespace) -> int:
    from rocsafe_orchestrator.fleet_command_node import command_fleet

    return command_fleet(arguments.verb, arguments.vehicles)
