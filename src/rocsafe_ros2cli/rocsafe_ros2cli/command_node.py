# SPDX-License-Identifier: Apache-2.0
"""The node of a verb: hidden, short-lived, in a context of its own."""

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.exceptions import NameValidationException
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from rocsafe_ros.domain.discovery import await_discovery
from rocsafe_ros.domain.network import leave_shared_memory
from rocsafe_ros2cli.command import CommandError

SLICE_S = 0.1
"""Longest time inside rcl, which Ctrl-C and SIGTERM do not interrupt."""


def open_context() -> Context:
    """Join the graph; signals are left to Python, so that a verb can clean up after Ctrl-C."""
    leave_shared_memory(os.environ)
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

    def __init__(self) -> None:
        self._context = open_context()
        self.node: Any = rclpy.create_node(
            f'_ros2cli_{os.getpid()}',
            context=self._context,
            start_parameter_services=False,
            parameter_overrides=[Parameter('start_type_description_service', value=False)],
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)

    def spin_until(self, is_done: Callable[[], bool], limit_s: float = float('inf')) -> bool:
        """Run callbacks until `is_done()`; return whether that was within `limit_s` seconds."""
        end = time.monotonic() + limit_s
        while not is_done():
            if time.monotonic() > end:
                return False
            with _signals_wait():
                self._executor.spin_once(timeout_sec=SLICE_S)
        return True

    def answer(self, future: Any, question: str, limit_s: float = float('inf')) -> Any:
        """Return the result of a future.

        Raises
        ------
        CommandError
            If it failed or did not come within `limit_s`; the text names `question`.
        """
        if not self.spin_until(future.done, limit_s):
            raise CommandError(f'No answer within {limit_s:g} s while {question}')
        if future.result() is None:
            raise CommandError(f'Exception while {question}: {future.exception()!r}')
        return future.result()

    def stop(self) -> None:
        """Stop the executor; only then may the clients that it waits for be destroyed.

        An action client that is destroyed earlier corrupts the memory of the process if its
        server was killed.
        """
        self._executor.shutdown(timeout_sec=1.0)

    def close(self) -> None:
        """Destroy the node and leave the graph."""
        self.stop()
        self.node.destroy_node()
        close_context(self._context)


@contextmanager
def _signals_wait() -> Iterator[None]:
    """Deliver SIGINT and SIGTERM at the end of the block; a second one at once.

    Python loses an exception that a signal raises in a `__del__`, and the spin has many.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    arrived: list[int] = []
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def restore() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    def note(number: int, _frame: FrameType | None) -> None:
        arrived.append(number)
        restore()

    for number, handler in before.items():
        if handler is not signal.SIG_IGN:
            signal.signal(number, note)
    try:
        yield
    finally:
        restore()
    if arrived:
        signal.raise_signal(arrived[0])


@contextmanager
def command_node() -> Iterator[CommandNode]:
    """Make a node for one verb and destroy it afterwards."""
    try:
        holder = CommandNode()
        try:
            yield holder
        finally:
            holder.close()
    except NameValidationException as error:
        raise CommandError(str(error)) from error


@contextmanager
def graph_node() -> Iterator[Any]:
    """Make a node that knows the others; yields the rclpy node."""
    with command_node() as holder:
        await_discovery(holder.node)
        yield holder.node
