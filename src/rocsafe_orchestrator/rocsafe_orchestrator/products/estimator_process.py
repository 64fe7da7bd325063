# SPDX-License-Identifier: Apache-2.0
"""Executables that estimate from the readings of a run, in processes of their own."""

import os
import subprocess
from collections.abc import Sequence

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.process_table.executables import ONE_THREAD, find_executable
from rocsafe_orchestrator.processes.answers import reason_of

# Thousands of readings take seconds; the machine may be busy.
TIMEOUT_S = 120.0


def run_estimator(package: str, executable: str, arguments: Sequence[str]) -> None:
    """Run an executable to its end.

    Raises
    ------
    SetupError
        If it is not installed.
    OrchestratorError
        If it estimates nothing, with the reason.
    """
    command = [str(find_executable(package, executable)), *arguments]
    try:
        done = subprocess.run(
            command,
            env={**os.environ, **ONE_THREAD},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            timeout=TIMEOUT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise OrchestratorError(f'nothing estimated: {error}') from error
    if done.returncode != 0:
        raise OrchestratorError(reason_of(done, executable))
