# SPDX-License-Identifier: Apache-2.0
"""Executables of the packages in the sourced workspace."""

import os
from pathlib import Path

from rocsafe_orchestrator.errors import SetupError

# Threads of the linear algebra cost more than they save on matrices this small.
ONE_THREAD = {'OPENBLAS_NUM_THREADS': '1', 'OMP_NUM_THREADS': '1'}


def find_executable(package: str, executable: str) -> Path:
    """Return the path of a package's executable in the sourced workspace.

    Raises
    ------
    SetupError
        If it is not installed, saying what to do.
    """
    prefixes = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    for prefix in filter(None, prefixes):
        path = Path(prefix) / 'lib' / package / executable
        if os.access(path, os.X_OK) and path.is_file():
            return path
    raise SetupError(
        f'executable {executable} of package {package} is not installed: run `make setup`, '
        'or `colcon build` and `. install/setup.bash`'
    )
