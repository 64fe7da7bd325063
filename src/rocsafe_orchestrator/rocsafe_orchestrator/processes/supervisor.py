# SPDX-License-Identifier: Apache-2.0
"""Starts, watches, restarts within limits, and stops processes.

Every process leads its own session, so that a Ctrl-C in the terminal reaches only the supervisor,
and so that the children of a process can be killed with it.
"""

import logging
import os
import re
import signal
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import IO

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.process_table.values import (
    Exit,
    Launch,
    ProcessEvent,
    ProcessEventKind,
)
from rocsafe_orchestrator.processes.process_start import Process, Start, begin_anew
from rocsafe_orchestrator.processes.session import Adopted

# Exit code of a process that refuses its parameters; a restart would not help.
EXIT_USAGE = 2
STOP_DEADLINE_S = 5.0
# Period of the checks whether stopped processes have ended.
STOP_POLL_S = 0.02
# Characters of the last line of a log that an event quotes.
# What ROS puts before a line in which a node tells why it ends; others are no reason.
_LOGGED = re.compile(r'^\[(WARN|ERROR|FATAL)\] \[[\d.]+\] \[[^]]*\]: ')
LONGEST_LINE = 300

log = logging.getLogger(__name__)


class _Child:
    """One process of the supervisor and its history."""

    def __init__(self, launch: Launch) -> None:
        self.launch = launch
        self.process: Process | Adopted | None = None
        self.restarts = 0
        self.start_at_s: float | None = None
        self.last_exit: Exit | None = None

    @property
    def is_running(self) -> bool:
        return self.process is not None


class Supervisor:
    """Starts and watches the processes of `launches`.

    Parameters
    ----------
    launches
        Processes that can be started; `start` starts one.
    environment
        Environment of every process.
    clock
        Monotonic clock, seconds.
    on_start
        Called with name and id of each process that was started.
    """

    def __init__(
        self,
        launches: Iterable[Launch],
        environment: Mapping[str, str] | None = None,
        clock: Callable[[], float] = time.monotonic,
        on_start: Callable[[str, int], None] = lambda _name, _pid: None,
    ) -> None:
        self._children = {launch.name: _Child(launch) for launch in launches}
        self._environment = dict(os.environ if environment is None else environment)
        self._clock = clock
        self._on_start = on_start

    @property
    def running(self) -> frozenset[str]:
        """Names of the processes that are running now."""
        return frozenset(name for name, child in self._children.items() if child.is_running)

    @property
    def restarts(self) -> dict[str, int]:
        """Number of restarts of each process that was restarted."""
        return {name: child.restarts for name, child in self._children.items() if child.restarts}

    def pid_of(self, name: str) -> int | None:
        """Return the process id of `name`, None while it is not running."""
        process = self._children[name].process
        return process.pid if process is not None else None

    def start(self, name: str, begin: Callable[[Start], Process] = begin_anew) -> None:
        """Start `name` unless it is running or waits for its restart.

        Parameters
        ----------
        begin
            How to start it; a restart always uses `begin_anew`.

        Raises
        ------
        SetupError
            If the executable cannot be started.
        """
        child = self._children[name]
        if not child.is_running and child.start_at_s is None:
            self._spawn(child, begin)

    def adopt(self, name: str, process: Adopted) -> None:
        """Take over a process that another supervisor has started."""
        self._children[name].process = process
        log.info('%s: taken over, process %d', name, process.pid)

    def poll(self) -> list[ProcessEvent]:
        """Notice processes that ended and start those again that are due; never waits."""
        events = []
        for child in self._children.values():
            if child.process is not None:
                ended = _ended(child.process)
                if ended is not None:
                    events.append(self._on_end(child, ended.code))
            elif child.start_at_s is not None and self._clock() >= child.start_at_s:
                events.append(self._restart(child))
        return events

    def _restart(self, child: _Child) -> ProcessEvent:
        child.start_at_s = None
        child.restarts += 1
        try:
            self._spawn(child)
        except SetupError as error:
            return self._event(child, ProcessEventKind.GAVE_UP, f'is not started again: {error}')
        text = f'started again ({child.restarts} of {child.launch.restart.limit})'
        return self._event(child, ProcessEventKind.RESTARTED, text)

    def stop(
        self,
        names: Iterable[str] | None = None,
        *,
        deadline_s: float = STOP_DEADLINE_S,
        must_hurry: Callable[[], bool] = lambda: False,
    ) -> None:
        """End `names`, by default all: ask every one, wait, then kill what is left.

        Returns when all have ended and been reaped. `must_hurry` is asked while waiting; once
        true, the wait is over.
        """
        children = [self._children[name] for name in (self._children if names is None else names)]
        for child in children:
            child.start_at_s = None
            # SIGINT would end a process that still imports its modules with a traceback.
            _signal(child.process, signal.SIGTERM)
        end = self._clock() + deadline_s
        while any(map(self._still_runs, children)) and self._clock() < end and not must_hurry():
            time.sleep(STOP_POLL_S)
        for child in children:
            if child.process is not None:
                log.warning('%s: killed, it did not end when asked', child.launch.name)
                _signal(child.process, signal.SIGKILL)
                self._note_exit(child, _wait(child.process))

    def _still_runs(self, child: _Child) -> bool:
        if child.process is None:
            return False
        ended = _ended(child.process)
        if ended is not None:
            self._note_exit(child, ended.code)
        return ended is None

    def _spawn(self, child: _Child, begin: Callable[[Start], Process] = begin_anew) -> None:
        launch = child.launch
        with _open_log(launch.log) as output:
            start = Start(command=launch.command, output=output, environment=self._environment)
            try:
                child.process = begin(start)
            except OSError as error:
                text = f'{launch.name}: cannot start {launch.command[0]}: {error.strerror}'
                raise SetupError(text) from error
        log.info('%s: started, process %d', launch.name, child.process.pid)
        self._on_start(launch.name, child.process.pid)

    def _on_end(self, child: _Child, code: int | None) -> ProcessEvent:
        self._note_exit(child, code)
        assert child.last_exit is not None  # noqa: S101 - for the type checker
        how = child.last_exit.text
        if child.launch.is_task and code == 0:
            return self._event(child, ProcessEventKind.DONE, how)
        policy = child.launch.restart
        if code == EXIT_USAGE or child.restarts >= policy.limit:
            return self._event(child, ProcessEventKind.GAVE_UP, _why(child, how))
        child.start_at_s = self._clock() + policy.pause_s(child.restarts)
        return self._event(child, ProcessEventKind.ENDED, how)

    def _note_exit(self, child: _Child, code: int | None) -> None:
        child.process = None
        child.last_exit = Exit(code=code)
        log.info('%s: %s', child.launch.name, child.last_exit.text)

    @staticmethod
    def _event(child: _Child, kind: ProcessEventKind, text: str) -> ProcessEvent:
        event = ProcessEvent(name=child.launch.name, kind=kind, text=text)
        level = logging.INFO if kind is ProcessEventKind.DONE else logging.WARNING
        log.log(level, '%s: %s: %s', event.name, kind.value, text)
        return event


def last_line(path: Path) -> str:
    """Return the last line with text in the file at `path`, empty if there is none."""
    try:
        lines = path.read_text(encoding='utf-8', errors='replace').strip().splitlines()
    except OSError:
        return ''
    return lines[-1][:LONGEST_LINE] if lines else ''


def _why(child: _Child, how: str) -> str:
    """Return why a process is not started again, with its own last words."""
    times = f' after {child.restarts} restarts' if child.restarts else ''
    words = _LOGGED.sub('', last_line(child.launch.log))
    return f'{how}{times}' + (f': {words}' if words and not words.startswith('[') else '')


def _open_log(path: Path) -> IO[bytes]:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open('ab')
    except OSError as error:
        raise SetupError(f'{path}: cannot write a log: {error.strerror}') from error


def _ended(process: Process | Adopted) -> Exit | None:
    """Return how a process ended, having ended what it left behind; None: it runs."""
    if isinstance(process, Adopted):
        return Exit(code=None) if process.has_ended else None
    flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
    try:
        if os.waitid(os.P_PID, process.pid, flags) is None:
            return None
    except ChildProcessError:
        # Starting another fork reaps those that have ended: `multiprocessing` does so.
        return Exit(code=process.wait())
    # Before it is reaped its id, which is that of its group, cannot have been given away.
    _signal(process, signal.SIGKILL)
    return Exit(code=process.wait())


def _wait(process: Process | Adopted) -> int | None:
    """Wait for the end of a process that was killed, and return its exit code."""
    if isinstance(process, Adopted):
        process.wait()
        return None
    return process.wait()


def _signal(process: Process | Adopted | None, number: signal.Signals) -> None:
    """Send `number` to `process` and to all that it has started."""
    if process is None:
        return
    try:
        if isinstance(process, Adopted):
            process.signal(number)
        else:
            os.killpg(process.pid, number)
    except ProcessLookupError:
        log.debug('process group %d has already ended', process.pid)
