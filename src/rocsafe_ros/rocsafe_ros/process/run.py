# SPDX-License-Identifier: Apache-2.0
"""The process of a node: start, spin, clean up and return an exit code.

One single-threaded events executor spins the nodes: it serves ten times as many messages as the
wait-set executors. Where a callback must wait, it is a coroutine, not a thread.
"""

import ctypes
import fcntl
import os
import signal
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import FrameType
from typing import Any

import rclpy
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.executors import ExternalShutdownException
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from rocsafe_ros.domain.network import bind_interfaces
from rocsafe_ros.parameters import ParameterError
from rocsafe_ros.process.health import HealthReporter
from rocsafe_ros.process.process_arguments import ArgumentError, help_wanted
from rocsafe_ros.process.standard_streams import open_standard_streams

EXIT_OK = 0
EXIT_FAILURE = 1
EXIT_USAGE = 2
# Longest delay between a signal and the end of an idle node.
POLL_S = 0.1
# DDS drops a process that is silent for 20 s, and some of the others never find it again.
STOOD_STILL_S = 15.0
# A process that took more of the processor than this share of the time did not stand still.
BUSY_SHARE = 0.05
# Code of `_spin` where nobody is there to start the process again but itself.
_AGAIN = 75
# The supervisor sets this to its process id; its nodes end when it ends.
SUPERVISOR_VARIABLE = 'ROCSAFE_SUPERVISOR_PID'
_PR_SET_PDEATHSIG = 1
# A file that the agents of a fleet keep locked: as long as they do, the nodes of their mission go
# on without their supervisor.
FLEET_LOCK_VARIABLE = 'ROCSAFE_FLEET_LOCK'
FLEET_LOOK_S = 1.0
# The agents' process may start again: longer than that takes on a busy machine.
FLEET_STARTS_S = 20.0
# A file that the supervisor of such a mission keeps locked, also one that resumes it.
SUPERVISOR_LOCK_VARIABLE = 'ROCSAFE_SUPERVISOR_LOCK'


class StopRequest:
    """Turns SIGINT and SIGTERM into a flag, so that no callback is interrupted."""

    def __init__(self) -> None:
        self.is_set = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._set)

    def _set(self, _number: int, _frame: FrameType | None) -> None:
        self.is_set = True


def run(
    make_node: Callable[[], Node | Iterable[Node]],
    args: Sequence[str] | None = None,
    *,
    outlives: Callable[[Any], bool] | None = None,
) -> int:
    """Spin the node or nodes that `make_node` returns until asked to stop; return the exit code.

    Parameters
    ----------
    make_node
        Makes the node or nodes.
    args
        Arguments of ROS; None: those of the process.
    outlives
        Returns, of what `make_node` returned, whether it is still needed; it then does not end
        with its supervisor. None: it does.

    Returns
    -------
    int
        0 after SIGINT or SIGTERM, when ROS is shut down, or after ``--help``; 2, with one line on
        standard error, if an argument or a parameter is wrong; 1, with one line, if there is not
        enough memory for it or its threads, or if the process stood still for so long that the
        others have given it up, and there is a supervisor to start it again; in a mission that
        goes on without one it starts itself again. Any other exception ends the process with its
        traceback, and its supervisor decides whether to start it again.
    """
    if outlives is None and os.environ.get(FLEET_LOCK_VARIABLE):
        outlives = FleetWatch(os.environ[FLEET_LOCK_VARIABLE])
    if outlives is None:
        _end_with_supervisor()
    stop = StopRequest()
    open_standard_streams()
    try:
        if args is None and (text := help_wanted(sys.argv, make_node)):
            print(text, end='')  # noqa: T201
            return EXIT_OK
        bind_interfaces(os.environ)
    except (ArgumentError, ParameterError) as error:
        print(f'error: {error}', file=sys.stderr)  # noqa: T201
        return EXIT_USAGE
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # noqa: BLE001 - rclpy's own error classes are not public
        print(f'cannot start ROS: {_first_line(error)}', file=sys.stderr)  # noqa: T201
        return EXIT_USAGE
    try:
        code = _spin(make_node, stop, outlives)
    except (ParameterError, InvalidParameterTypeException) as error:
        print(f'error: {error}', file=sys.stderr)  # noqa: T201
        return EXIT_USAGE
    except MemoryError as error:
        print(f'error: not enough memory: {_first_line(error)}', file=sys.stderr)  # noqa: T201
        return EXIT_FAILURE
    finally:
        rclpy.try_shutdown()
    if code == _AGAIN:
        os.execv(sys.argv[0], sys.argv)  # noqa: S606 - the command of this very process
    return code


def _spin(
    make_node: Callable[[], Node | Iterable[Node]],
    stop: StopRequest,
    outlives: Callable[[Any], bool] | None,
) -> int:
    watch = _StandstillWatch()
    made = make_node()
    nodes = [made] if isinstance(made, Node) else list(made)
    executor = EventsExecutor()
    for node in nodes:
        executor.add_node(node)
    # The first node is that of the process; others are small ones in vehicles' namespaces.
    health = HealthReporter(nodes[0])
    try:
        while rclpy.ok() and not stop.is_set and (outlives is None or outlives(made)):
            # Handles all events of this time; `spin_once` would return to Python after each one.
            executor.spin_until_future_complete(Future(), POLL_S)
            stood_s = watch.look_s()
            if not stood_s or not os.environ.get(SUPERVISOR_VARIABLE):
                continue
            is_left = is_orphan()
            # The memory of agents is all that is left of their mission: the others, which are
            # new then, find them again.
            if not is_left or isinstance(outlives, FleetWatch):
                text = f'stood still for {stood_s:.0f} s: ends, to be started again'
                print(text, file=sys.stderr)  # noqa: T201
                return _AGAIN if is_left else EXIT_FAILURE
    except ExternalShutdownException:
        pass
    finally:
        health.close()
        for node in nodes:
            executor.remove_node(node)
            node.destroy_node()
    return EXIT_OK


class _StandstillWatch:
    """Notices that the process was stopped and goes on: by SIGSTOP, or a container's pause."""

    def __init__(self) -> None:
        self._looked_s, self._taken_s = time.monotonic(), time.process_time()

    def look_s(self) -> float:
        """Return for how long it stood still since the last look, 0 if it did not."""
        before_s, taken_s = self._looked_s, self._taken_s
        self._looked_s, self._taken_s = time.monotonic(), time.process_time()
        passed_s = self._looked_s - before_s
        is_busy = self._taken_s - taken_s > BUSY_SHARE * passed_s
        return 0.0 if passed_s < STOOD_STILL_S or is_busy else passed_s


def is_orphan() -> bool:
    """Return whether the supervisor of this process has died, and no other has taken its place."""
    if lock := os.environ.get(SUPERVISOR_LOCK_VARIABLE):
        return not is_locked(lock)
    supervisor = os.environ.get(SUPERVISOR_VARIABLE)
    return bool(supervisor) and os.getppid() != int(supervisor or 0)


class FleetWatch:
    """Looks now and then whether a mission goes on: its supervisor lives, or its agents fly.

    Parameters
    ----------
    lock
        File that the agents keep locked.
    """

    def __init__(self, lock: str) -> None:
        self._lock = lock
        self._look_s = 0.0
        self._seen_s = time.monotonic()

    def __call__(self, _made: object) -> bool:
        """Return whether the mission goes on."""
        now_s = time.monotonic()
        if now_s >= self._look_s:
            self._look_s = now_s + FLEET_LOOK_S
            if not is_orphan() or is_locked(self._lock):
                self._seen_s = now_s
        return now_s - self._seen_s < FLEET_STARTS_S


def is_locked(path: str) -> bool:
    """Return whether another process keeps a file locked."""
    try:
        with Path(path).open('rb') as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def _end_with_supervisor() -> None:
    """Ask the kernel for SIGTERM when the supervisor that started this process dies."""
    supervisor = os.environ.get(SUPERVISOR_VARIABLE)
    if supervisor:
        end_with(int(supervisor))


def end_with(parent: int) -> None:
    """Ask the kernel for SIGTERM when the process `parent`, which started this one, dies."""
    if not sys.platform.startswith('linux'):
        return
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    # The parent may have ended before prctl took effect.
    if os.getppid() != parent:
        sys.exit(EXIT_FAILURE)


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
