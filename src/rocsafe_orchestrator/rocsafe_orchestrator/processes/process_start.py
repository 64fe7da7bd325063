# SPDX-License-Identifier: Apache-2.0
"""Start of a process: as a new program, or as a fork of this process.

An interpreter needs half a second of a core to import ROS, numpy and a node: ten nodes kept two
cores busy for five seconds before any of them could answer. A fork shares the imported modules.

The fork server of `multiprocessing` does not fit: its processes are no children of this one, so
that `os.waitid` cannot tell their end before their process group is signalled, and the server has
to import again what this process has imported.
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
# Groups of entry points with the executables of a package: of colcon's build, and of wheels, whose
# executables stay out of `bin` (tools/distribution/python_wheel.py writes both).
_EXECUTABLES = frozenset({'console_scripts', 'ros2_executables'})
# Second line of an executable that a wheel brings.
_LAUNCHER = b"'''exec' "

log = logging.getLogger(__name__)


class Process(Protocol):
    """A child process."""

    @property
    def pid(self) -> int:
        """Id of the process and of its session."""

    def wait(self) -> int:
        """Wait for its end, reap it and return the exit code, negative for a signal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Command, output and environment of a process to start.

    Attributes
    ----------
    command
        Executable, as a path, and arguments.
    output
        File that takes its output and errors.
    environment
        All of its environment variables.
    """

    command: tuple[str, ...]
    output: IO[bytes]
    environment: Mapping[str, str]


def begin_anew(start: Start) -> Process:
    """Start a program in a new session.

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


def begin_as_fork(start: Start) -> Process:
    """Start a script of this interpreter as a fork of this process, any other program anew.

    The modules of the script's console entry point are imported here, once for all forks. Must
    be called before ROS is started; a process with several Python threads is not forked, because
    locks that other threads hold would never be released in the fork. (The two threads of LTTng
    that the libraries of ROS start sleep unless tracing is on; forks are not traced.)

    Raises
    ------
    OSError
        If it cannot be started.
    """
    script = Path(start.command[0])
    if not _is_of_this_interpreter(script) or threading.active_count() > 1:
        return begin_anew(start)
    import_for(script)
    # Garbage collection of the objects made so far would copy the shared memory.
    gc.freeze()
    return _Fork(start)


class _Fork:
    """A fork of this process."""

    def __init__(self, start: Start) -> None:
        heard, told = os.pipe()
        context = multiprocessing.get_context('fork')
        self._process = context.Process(target=_run_script, args=(start, told))
        # Block signals until the fork has set its own handlers.
        former = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)
        try:
            self._process.start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, former)
            os.close(told)
        # The fork closes its end after setsid: before, its process group cannot be signalled.
        os.read(heard, 1)
        os.close(heard)

    @property
    def pid(self) -> int:
        """Id of the process and of its session."""
        assert self._process.pid is not None  # noqa: S101 - it was started
        return self._process.pid

    def wait(self) -> int:
        """Wait for its end, reap it and return the exit code, negative for a signal."""
        self._process.join()
        assert self._process.exitcode is not None  # noqa: S101 - it has ended
        return self._process.exitcode


def _is_of_this_interpreter(script: Path) -> bool:
    """Whether it names this interpreter, or is a launcher that a wheel put beside it."""
    try:
        with script.open('rb') as file:
            first, second = file.readline(4096), file.readline(4096)
    except OSError:
        return False
    if first.rstrip() == b'#!' + os.fsencode(sys.executable):
        return True
    return second.startswith(_LAUNCHER) and script.is_relative_to(sys.prefix)


def import_for(script: Path) -> None:
    """Import the console entry point that a package's script, `lib/PACKAGE/NAME`, runs."""
    if not _is_of_this_interpreter(script):
        return
    try:
        distribution = importlib.metadata.distribution(script.parent.name)
        for point in distribution.entry_points.select(name=script.name):
            if point.group in _EXECUTABLES:
                point.load()
    except Exception as error:  # noqa: BLE001 - whatever a module raises while it is imported
        # The fork fails likewise and writes the reason to its log.
        log.info('%s: nothing imported for it: %s', script, error)


def _run_script(start: Start, told: int) -> None:
    """Set up this fork like a new interpreter, and run the script of `start`."""
    os.setsid()
    os.close(told)
    for number in _SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    _redirect_to(start.output)
    _set_name(Path(start.command[0]).name)
    os.environ.clear()
    os.environ.update(start.environment)
    sys.argv = list(start.command)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, _SIGNALS)
    runpy.run_path(start.command[0], run_name='__main__')


def _redirect_to(output: IO[bytes]) -> None:
    """Redirect standard output, errors and logging to `output`, unbuffered."""
    with Path(os.devnull).open('rb') as nothing:
        os.dup2(nothing.fileno(), 0)
    for number in (1, 2):
        os.dup2(output.fileno(), number)
    sys.stdout = open(1, 'w', encoding='utf-8', buffering=1, closefd=False)  # noqa: SIM115
    sys.stderr = open(2, 'w', encoding='utf-8', buffering=1, closefd=False)  # noqa: SIM115
    # The parent logs to a file of its own.
    package = logging.getLogger(__name__.partition('.')[0])
    package.handlers.clear()
    package.setLevel(logging.NOTSET)
    package.propagate = True


def _set_name(name: str) -> None:
    """Set the name that `ps -e` and `top` show."""
    with contextlib.suppress(OSError):
        Path('/proc/self/comm').write_text(name, encoding='utf-8')
