# SPDX-License-Identifier: Apache-2.0
"""The command line of a node's process: help, and the refusal of arguments that ROS ignores."""

import inspect
import re
from collections.abc import Callable, Sequence
from pathlib import PurePath
from typing import Any

from rclpy.utilities import remove_ros_args

_HELP = {'-h', '--help'}
_ROLE = re.compile(r'``([^`]*)``')


class ArgumentError(ValueError):
    """The command line has an argument that a node does not know."""


def help_wanted(argv: Sequence[str], make_node: Callable[[], Any]) -> str:
    """Return the help if `argv`, program first, asks for it, else nothing.

    A node knows arguments of ROS alone. rclpy ignores all others silently, and a parameter given
    without ``--ros-args`` would keep its default.

    Raises
    ------
    ArgumentError
        If there is an argument of another kind.
    """
    others = remove_ros_args(argv)[1:]
    if _HELP & set(others):
        return _help(argv[0], make_node)
    if others:
        raise ArgumentError(
            f'argument {others[0]!r} is not known: a parameter is set by '
            '--ros-args -p NAME:=VALUE; more: --help'
        )
    return ''


def _help(program: str, make_node: Callable[[], Any]) -> str:
    module = inspect.getmodule(make_node)
    about = _ROLE.sub(r'\1', (inspect.getdoc(module) or '').partition('\n\n')[0])
    return (
        f'usage: {PurePath(program).name} [--ros-args [-r __ns:=/NAME] [-p NAME:=VALUE] ...\n'
        f'       [--params-file FILE]]\n\n{about}\n\n'
        'It is a ROS 2 node and runs until Ctrl-C. config/rocsafe.yaml lists its parameters with\n'
        'unit, limits and default; docs/interfaces.md lists its topics, services and actions.\n'
    )
