# SPDX-License-Identifier: Apache-2.0
"""`rocsafe check PLAN.json`: check that a plan meets its request and states true figures."""

from pathlib import Path

from rich.console import Console

from rocsafe_orchestrator.errors import EXIT_COMPLETE, OrchestratorError
from rocsafe_orchestrator.planning_commands.plan_tables import quality_table, route_table
from rocsafe_orchestrator.planning_commands.replan_command import plan_of
from rocsafe_planner.checking.plan_checker import check_plan


def check_plan_file(path: Path, terrain: Path | None, console: Console) -> int:
    """Check a plan and print its figures.

    Raises
    ------
    ScenarioError
        If the file is no plan, or a plan over another terrain.
    OrchestratorError
        If the checker finds faults: one line each.
    """
    plan = plan_of(path, terrain)
    faults = check_plan(plan)
    if faults:
        raise OrchestratorError('\n'.join(f'{path}: {fault}' for fault in faults))
    console.print(f'{path}: the plan has no fault', style='bold green', highlight=False)
    console.print(quality_table(path, plan))
    console.print(route_table(plan))
    return EXIT_COMPLETE
