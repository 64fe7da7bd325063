# SPDX-License-Identifier: Apache-2.0
"""Plans that the independent checker has passed: only these are published.

Measured on one core of a shared machine, the check takes 0.03 s for 60 viewpoints, 0.15 s for 370
and 0.5 s for 1450.
"""

from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.errors import FaultyPlanError
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.planning import Progress, plan_survey

MOST_FAULTS = 3


def checked_plan(
    request: SurveyRequest, on_progress: Progress = lambda _makespan, _bound: True
) -> SurveyPlan:
    """Return the plan of a request after the independent checker has found no fault in it.

    Raises
    ------
    ValueError, PlannerError
        As `plan_survey` does; FaultyPlanError if the checker finds a fault.
    """
    plan = plan_survey(request, on_progress)
    require_sound(plan)
    return plan


def require_sound(plan: SurveyPlan) -> None:
    """Raise FaultyPlanError if the independent checker finds a fault in a plan."""
    faults = check_plan(plan)
    if faults:
        shown = '; '.join(faults[:MOST_FAULTS])
        raise FaultyPlanError(f'the plan checker found {len(faults)} faults: {shown}')
