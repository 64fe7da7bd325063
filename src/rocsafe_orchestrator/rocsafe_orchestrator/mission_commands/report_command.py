# SPDX-License-Identifier: Apache-2.0
"""`rocsafe report`: the products of a run, made again from what it recorded."""

from pathlib import Path

from rich.console import Console

from rocsafe_orchestrator.errors import EXIT_COMPLETE, EXIT_FAILED
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.errors import ScenarioError


def report(path: Path, console: Console) -> int:
    """Write the products of the run directory `path` and print where they are.

    Raises
    ------
    ScenarioError
        If `path` is no run directory.
    """
    run = RunDirectory(path.resolve())
    if not run.run_info.is_file():
        raise ScenarioError(f'{path}: is no run directory (it has no {run.run_info.name})')
    from rocsafe_orchestrator.write_products import write_products

    write_products(run.path)
    products = (run.report, run.summary, run.readings, run.recording, run.mosaic)
    for product in products:
        if product.is_file():
            console.print(str(product), highlight=False, soft_wrap=True)
    return EXIT_COMPLETE if run.report.is_file() else EXIT_FAILED
