# SPDX-License-Identifier: Apache-2.0
"""The process that makes the products of a run: `python -m rocsafe_orchestrator.report_process`.

It is started while the map is written: sources are estimated meanwhile. What changes the recording
waits until the orchestrator says that all is recorded.
"""

import logging
import os
import sys
import time
from pathlib import Path

from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_orchestrator.write_products import EarlyEstimates, estimate_early, write_products

LOOK_S = 0.02

log = logging.getLogger(__name__)


def main(path: Path) -> int:
    """Make the products of the run directory `path`; 1 if the orchestrator has died before."""
    run, orchestrator = RunDirectory(path), os.getppid()
    early = None if run.flown.exists() else _early(run)
    while not run.flown.exists():
        if os.getppid() != orchestrator:
            return 1
        time.sleep(LOOK_S)
    write_products(path, early)
    return 0


def _early(run: RunDirectory) -> EarlyEstimates | None:
    """Estimate sources early; what goes wrong does so again, and is told, when all is recorded."""
    try:
        return estimate_early(run)
    except (OSError, ValueError) as error:
        log.warning('no early estimate: %s', error)
        return None


if __name__ == '__main__':
    sys.exit(main(Path(sys.argv[1])))
