# SPDX-License-Identifier: Apache-2.0
"""The operator's page beside a mission, and the seal of its run: commands of rocsafe_console.

Neither belongs to the processes of the mission: it flies the same without them.
"""

import logging
import os
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Event, Thread

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.process_table.launches import SUPERVISOR_VARIABLE
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.run import EXIT_OK, EXIT_USAGE

PACKAGE = 'rocsafe_console'
STOP_S = 5.0
RESTART_S = 0.2
MOST_STARTS = 100
# A run of a thousand photographs is hashed in seconds.
SEAL_S = 300.0

_log = logging.getLogger(__name__)


@contextmanager
def operators_page(is_wanted: bool, run: RunDirectory) -> Iterator[None]:
    """Serve the operator's page, which prints its address, until the end of the block."""
    if not is_wanted:
        yield
        return
    page = KeptProcess([str(find_executable(PACKAGE, 'console')), '--runs', str(run.path.parent)])
    try:
        yield
    finally:
        page.close()


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
