# SPDX-License-Identifier: Apache-2.0
"""What a plan is to be small in, by name: the five choices of the seed system."""

from collections.abc import Callable

from rocsafe_planner.plan import SurveyPlan

OBJECTIVE_VALUES: dict[str, Callable[[SurveyPlan], float]] = {
    'longest_time': lambda plan: plan.makespan_s,
    'longest_distance': lambda plan: plan.longest_route_m,
    'total_time': lambda plan: plan.total_duration_s,
    'total_distance': lambda plan: plan.total_length_m,
    'energy': lambda plan: plan.total_energy_wh,
}
"""Value of a plan by name of the objective, in s, m, s, m and Wh."""
