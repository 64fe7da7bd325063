# SPDX-License-Identifier: Apache-2.0
"""Objectives of a plan by name: the five of the ROCSAFE paper."""

import math
from collections.abc import Callable

from rocsafe_planner.plan.plan import SurveyPlan

OBJECTIVE_VALUES: dict[str, Callable[[SurveyPlan], float]] = {
    'longest_time': lambda plan: plan.makespan_s,
    'longest_distance': lambda plan: plan.longest_route_m,
    'total_time': lambda plan: plan.total_duration_s,
    'total_distance': lambda plan: plan.total_length_m,
    'energy': lambda plan: plan.total_energy_wh,
}
"""Value of a plan by name of the objective, in `OBJECTIVE_UNITS`."""


OBJECTIVE_UNITS = {
    'longest_time': 's',
    'longest_distance': 'm',
    'total_time': 's',
    'total_distance': 'm',
    'energy': 'Wh',
}


def objective_gap(plan: SurveyPlan) -> float:
    """Return the greatest relative excess of the objective over the best value; NaN if unknown."""
    bound = plan.objective_bound
    if math.isnan(bound):
        return math.nan
    return (
        OBJECTIVE_VALUES[plan.request.effort.objective](plan) / bound - 1.0 if bound > 0.0 else 0.0
    )
