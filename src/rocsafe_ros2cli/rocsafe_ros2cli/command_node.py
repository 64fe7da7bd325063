# SPDX-License-Identifier: Apache-2.0
"""The node of a verb: hidden, short-lived, in a context of its own."""

import os
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.exceptions import NameValidationException
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from rocsafe_ros2cli.command import CommandError
from rocsafe_ros2cli.discovery import await_discovery

SLICE_S = 0.1
"""Longest time inside rcl, which Ctrl-C and SIGTERM do not interrupt."""

NAME_PREFIX = '_ros2cli'


def add_node_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of verbs that look at the graph."""
    parser.add_argument(
        '--spin-time',
        type=float,
        help='Seconds to wait for discovery (default: until all nodes of this machine are found)',
    )
    parser.add_argument(
        '-s', '--use-sim-time', action='store_true', help='Enable ROS simulation time'
    )
    parser.add_argument(
        '--no-daemon', action='store_true', help='Accepted and without effect: there is no daemon'
    )


def open_context() -> Context:
    """Join the graph; signals are left to Python, so that a verb can clean up after Ctrl-C."""
    context = Context()
    rclpy.init(args=[], context=context, signal_handler_options=SignalHandlerOptions.NO)
    return context


def close_context(context: Context) -> None:
    """Leave the graph."""
    rclpy.shutdown(context=context)


class CommandNode:
    """A node and its executor.

    Attributes
    ----------
    node
        The rclpy node.
    """

    def __init__(self, name: str = '', *, use_sim_time: bool = False) -> None:
        self._context = open_context()
        self.node: Any = rclpy.create_node(
            name or f'{NAME_PREFIX}_{os.getpid()}',
            context=self._context,
            start_parameter_services=False,
            parameter_overrides=[
                Parameter('use_sim_time', value=use_sim_time),
                Parameter('start_type_description_service', value=False),
            ],
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def spin_until(self, is_done: Callable[[], bool], limit_s: float = float('inf')) -> bool:
        """Run callbacks until `is_done()`; return whether that was within `limit_s` seconds."""
        end = time.monotonic() + limit_s
        while not is_done():
            if time.monotonic() > end:
                return False
            self._executor.spin_once(timeout_sec=SLICE_S)
        return True

    def stop(self) -> None:
        """Wait for nothing any more: only then may what was waited for be destroyed.

        A client of an action that goes before damages the memory of the process, if its server
        was killed.
        """
        self._executor.shutdown(timeout_sec=1.0)

    def close(self) -> None:
        """Take the node down."""
        self.stop()
        self.node.destroy_node()
        close_context(self._context)


@contextmanager
def command_node(name: str = '', *, use_sim_time: bool = False) -> Iterator[CommandNode]:
    """Make a node for one verb and take it down afterwards."""
    try:
        holder = CommandNode(name, use_sim_time=use_sim_time)
        try:
            yield holder
        finally:
            holder.close()
    except NameValidationException as error:
        raise CommandError(str(error)) from error


@contextmanager
def graph_node(options: Namespace) -> Iterator[Any]:
    """Make a node that has met the others; yields the rclpy node."""
    with command_node(use_sim_time=getattr(options, 'use_sim_time', False)) as holder:
        await_discovery(holder.node, getattr(options, 'spin_time', None))
        yield holder.node
