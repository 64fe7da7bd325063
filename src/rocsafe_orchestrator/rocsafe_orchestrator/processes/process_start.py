# SPDX-License-Identifier: Apache-2.0
"""How a process begins: as a program of its own, or as a copy of this one.

An interpreter needs half a second of a core until it has imported ROS, numpy and a node: ten
nodes kept two cores busy for five seconds before any of them could answer. A copy has imported
already what this process has, and shares that memory until it writes to it.
"""

import contextlib
import gc
import importlib.metadata
import logging
import multiprocessing
import os
import runpy
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Protocol

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

log = logging.getLogger(__name__)


class Process(Protocol):
    """A process that this one has started."""

    @property
    def pid(self) -> int:
        """Its id, and that of its session."""

    def wait(self) -> int:
        """Wait for its end and return the exit code, negative for a signal; forget it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """What a process begins with.

    Attributes
    ----------
    command
        Executable, as a path, and arguments.
    output
        Takes what it prints.
    environment
        All of its variables.
    """

    command: tuple[str, ...]
    output: IO[bytes]
    environment: Mapping[str, str]


def begin_anew(start: Start) -> Process:
    """Start a program in a session of its own.

    Raises
    ------
    OSError
        If it cannot be started.
    """
    return subprocess.Popen(
        start.command,
        stdin=subprocess.DEVNULL,
        stdout=start.output,
        stderr=subprocess.STDOUT,
        env=start.environment,
        start_new_session=True,
    )


def begin_as_copy(start: Start) -> Process:
    """Start a script of this interpreter as a copy of this process, anything else anew.

    What the script's console entry point imports is imported here, once for all copies. Must
    come before ROS is started, and only a process with a single thread of Python is copied: locks
    that other threads hold would never open in the copy. (The two threads of LTTng that ROS's
    libraries bring sleep until somebody traces; copies are not traced.)

    Raises
    ------
    OSError
        If it cannot be started.
    """
    script = Path(start.command[0])
    if not _is_of_this_interpreter(script) or threading.active_count() > 1:
        return begin_anew(start)
    _import_for(script)
    # What is here now stays: looking through it would copy the memory that is shared.
    gc.freeze()
    return _Copy(start)


class _Copy:
    """A process that began as a copy of this one."""

    def __init__(self, start: Start) -> None:
        heard, told = os.pipe()
        context = multiprocessing.get_context('fork')
        self._process = context.Process(target=_run_script, args=(start, told))
        # Until the copy has handlers of its own a signal is kept for it, not lost to ours.
        former = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, former)
            os.close(told)
        # Closed once the copy leads a session: before, its group could not be signalled.
        os.read(heard, 1)
        os.close(heard)

    @property
    def pid(self) -> int:
        """Its id, and that of its session."""
        assert self._process.pid is not None  # noqa: S101 - it was started
        return self._process.pid

    def wait(self) -> int:
        """Wait for its end and return the exit code, negative for a signal; forget it."""
        self._process.join()
        assert self._process.exitcode is not None  # noqa: S101 - it has ended
        return self._process.exitcode


def _is_of_this_interpreter(script: Path) -> bool:
    try:
        with script.open('rb') as file:
            first = file.readline(4096)
    except OSError:
        return False
    return first.rstrip() == b'#!' + os.fsencode(sys.executable)


def _import_for(script: Path) -> None:
    """Import the console entry point that a package's script, `lib/PACKAGE/NAME`, runs."""
    try:
        distribution = importlib.metadata.distribution(script.parent.name)
        points = distribution.entry_points.select(group='console_scripts', name=script.name)
        for point in points:
            point.load()
    except (ImportError, AttributeError) as error:
        # The copy meets it too, and its last words say so in its own log.
        log.info('%s: nothing imported for it: %s', script, error)


def _run_script(start: Start, told: int) -> None:
    """Be what a new interpreter would be that runs the script of `start`."""
    os.setsid()
    os.close(told)
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    _speak_to(start.output)
    _be_called(Path(start.command[0]).name)
    os.environ.clear()
    os.environ.update(start.environment)
    sys.argv = list(start.command)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
    runpy.run_path(start.command[0], run_name='__main__')


def _speak_to(output: IO[bytes]) -> None:
    """Let all that this process prints or notes go to `output` at once."""
    with Path(os.devnull).open('rb') as nothing:
        os.dup2(nothing.fileno(), 0)
    for number in (1, 2):
        os.dup2(output.fileno(), number)
    sys.stdout = open(1, 'w', encoding='utf-8', buffering=1, closefd=False)  # noqa: SIM115
    sys.stderr = open(2, 'w', encoding='utf-8', buffering=1, closefd=False)  # noqa: SIM115
    # What the original notes goes to a file of its own.
    package = logging.getLogger(__name__.partition('.')[0])
    package.handlers.clear()
    package.setLevel(logging.NOTSET)
    package.propagate = True


def _be_called(name: str) -> None:
    """Show `name` in `ps -e` and `top`, instead of that of the original."""
    with contextlib.suppress(OSError):
        Path('/proc/self/comm').write_text(name, encoding='utf-8')
