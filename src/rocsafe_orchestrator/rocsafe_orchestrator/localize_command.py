# SPDX-License-Identifier: Apache-2.0
"""`rocsafe localize`: sources from anyone's file of readings, without flying."""

import os
import subprocess
from collections.abc import Sequence

from rocsafe_orchestrator.errors import EXIT_COMPLETE, OrchestratorError
from rocsafe_orchestrator.launches import find_executable

TIMEOUT_S = 600.0
# Threads of the linear algebra would only wait for each other on matrices this small.
ONE_THREAD = {'OPENBLAS_NUM_THREADS': '1', 'OMP_NUM_THREADS': '1'}


def localize(arguments: Sequence[str]) -> int:
    """Run the executable `localize` with `arguments`; it prints what it finds.

    Raises
    ------
    OrchestratorError: if there is nothing to localise from; the reason is told.
    """
    command = [str(find_executable('rocsafe_radiation', 'localize')), *arguments]
    try:
        done = subprocess.run(
            command,
            env={**os.environ, **ONE_THREAD},
            stderr=subprocess.PIPE,
            text=True,
            timeout=TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise OrchestratorError(f'no sources within {TIMEOUT_S:g} s') from error
    if done.returncode != 0:
        words = done.stderr.strip().splitlines() or [f'localize ended with {done.returncode}']
        raise OrchestratorError(words[-1].removeprefix('error: '))
    return EXIT_COMPLETE
