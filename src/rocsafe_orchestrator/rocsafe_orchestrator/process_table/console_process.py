# SPDX-License-Identifier: Apache-2.0
"""The operator's page beside a mission, and the seal of its run: commands of rocsafe_console.

Neither belongs to the processes of the mission: it flies the same without them.
"""

import logging
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from threading import Event, Thread

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.process_table.launches import SUPERVISOR_VARIABLE
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.process.run import EXIT_OK, EXIT_USAGE

PACKAGE = 'rocsafe_console'
STOP_S = 5.0
RESTART_S = 0.2
POLL_S = 0.1
MOST_STARTS = 100
# A run of a thousand photographs is hashed in seconds.
SEAL_S = 300.0

_log = logging.getLogger(__name__)


class OperatorsPage:
    """The operator's page beside a mission, served until the end of the ``with`` block.

    Parameters
    ----------
    is_wanted
        Whether there is one at all.
    """

    def __init__(self, *, is_wanted: bool) -> None:
        self._is_wanted = is_wanted
        self._process: KeptProcess | None = None

    def __enter__(self) -> 'OperatorsPage':
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            self._process.close()

    def begin(self, run: RunDirectory) -> None:
        """Serve it; it prints its address."""
        if self._is_wanted:
            console = str(find_executable(PACKAGE, 'console'))
            self._process = KeptProcess([console, '--runs', str(run.path.parent)])

    def stay(self, is_ended: Callable[[], bool]) -> None:
        """Wait, with the page of a mission that has ended, until somebody at a terminal ends it.

        Without a terminal nobody would: the page ends with its mission.
        """
        if self._process is None or not (os.isatty(0) and os.isatty(1)):
            return
        if self._process.is_kept:
            sys.stdout.write("the operator's page goes on, with the report: Ctrl-C ends it\n")
            sys.stdout.flush()
        while self._process.is_kept and not is_ended():
            time.sleep(POLL_S)


class KeptProcess:
    """A process that is started again when it dies, until it is closed.

    One that ends by itself, or refuses its arguments, is left: it would do so again. A page stays
    logged in, because sessions outlive the process.

    Parameters
    ----------
    command
        The program and its arguments.
    """

    def __init__(self, command: Sequence[str]) -> None:
        self._command = list(command)
        self._is_closed = Event()
        self.process = self._begin()
        self._keeper = Thread(target=self._keep, name='page', daemon=True)
        self._keeper.start()

    @property
    def is_kept(self) -> bool:
        """Whether it runs, or is about to be started again."""
        return self._keeper.is_alive()

    def close(self) -> None:
        """End the process, and do not start it again."""
        self._is_closed.set()
        self.process.terminate()
        self._keeper.join(STOP_S)
        if self._keeper.is_alive():
            self.process.kill()
            self._keeper.join()

    def _begin(self) -> 'subprocess.Popen[bytes]':
        environment = {**os.environ, SUPERVISOR_VARIABLE: str(os.getpid())}
        # Ctrl-C is for the mission, which ends this one.
        return subprocess.Popen(
            self._command, env=environment, stdin=subprocess.DEVNULL, start_new_session=True
        )

    def _keep(self) -> None:
        for _ in range(MOST_STARTS):
            code = self.process.wait()
            if code in (EXIT_OK, EXIT_USAGE) or self._is_closed.wait(RESTART_S):
                return
            _log.warning("the operator's page ended with %d: it is started again", code)
            self.process = self._begin()
            if self._is_closed.is_set():
                self.process.terminate()
        self.process.wait()


def seal(run: RunDirectory) -> None:
    """Seal a run; what hinders it is written to the log of the orchestrator."""
    try:
        command = [str(find_executable(PACKAGE, 'seal')), str(run.path)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=SEAL_S, check=False)
    except (OrchestratorError, OSError, subprocess.TimeoutExpired) as error:
        _log.warning('the run is not sealed: %s', error)
        return
    if done.returncode:
        _log.warning('the run is not sealed: %s', done.stderr.strip())
