# SPDX-License-Identifier: Apache-2.0
"""`rocsafe console`: serves the operator's page, and runs the node that hears the mission."""

import os
import sys
from collections.abc import Sequence

from rocsafe_console.console_command import context_of
from rocsafe_console.console_node import ConsoleNode
from rocsafe_console.errors import ConsoleError
from rocsafe_console.web.context import Context
from rocsafe_console.web.server import ServerThread
from rocsafe_ros.process.run import EXIT_USAGE, run

REACH = (
    'ROCSAFE_INTERFACES', 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_STATIC_PEERS',
    'ROS_DISCOVERY_SERVER', 'ROS_LOCALHOST_ONLY',
)  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve until asked to stop, and return the exit code."""
    try:
        context = context_of(arguments)
        server = ServerThread(context, _say)
    except (ConsoleError, OSError) as error:
        _say(f'error: {error}')
        return EXIT_USAGE
    token = f'#token={context.options.token}' if context.options.token else ''
    sys.stdout.write(f'console: {server.address}{token}\n')
    sys.stdout.flush()
    if not any(os.environ.get(name) for name in REACH):
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    try:
        return run(lambda: _node(context), args=[])
    finally:
        server.close()
        context.desk.close()


def _node(context: Context) -> ConsoleNode:
    context.fleet = node = ConsoleNode(context.live, context.desk)
    return node


def _say(text: str) -> None:
    sys.stderr.write(f'{text}\n')


if __name__ == '__main__':
    sys.exit(main())
