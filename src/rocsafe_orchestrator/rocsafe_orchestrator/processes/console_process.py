# SPDX-License-Identifier: Apache-2.0
"""The operator's page beside a mission, and the seal of its run: commands of rocsafe_console.

Neither belongs to the processes of the mission: it flies the same without them.
"""

import logging
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.processes.executables import find_executable
from rocsafe_orchestrator.processes.launches import SUPERVISOR_VARIABLE
from rocsafe_orchestrator.run_directory import RunDirectory

PACKAGE = 'rocsafe_console'
STOP_S = 5.0
# A run of a thousand photographs is hashed in seconds.
SEAL_S = 300.0

_log = logging.getLogger(__name__)


@contextmanager
def operators_page(is_wanted: bool, run: RunDirectory) -> Iterator[None]:
    """Serve the operator's page, which prints its address, until the end of the block."""
    if not is_wanted:
        yield
        return
    command = [str(find_executable(PACKAGE, 'console')), '--runs', str(run.path.parent)]
    environment = {**os.environ, SUPERVISOR_VARIABLE: str(os.getpid())}
    # Ctrl-C is for the mission, which ends this one.
    page = subprocess.Popen(
        command, env=environment, stdin=subprocess.DEVNULL, start_new_session=True
    )
    try:
        yield
    finally:
        page.terminate()
        try:
            page.wait(STOP_S)
        except subprocess.TimeoutExpired:
            page.kill()
            page.wait()


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
