# SPDX-License-Identifier: Apache-2.0
"""A plan as tables on the console."""

import math
from pathlib import Path

from rich.table import Table

from rocsafe_planner.plan.objective import OBJECTIVE_UNITS, OBJECTIVE_VALUES, objective_gap
from rocsafe_planner.plan.plan import Route, SurveyPlan
from rocsafe_planner.plan.survey_options import METHODS, Effort
from rocsafe_view.formats import clock


def quality_table(path: Path, plan: SurveyPlan) -> Table:
    """Return the figures of a plan; `path` is what it was made from."""
    effort = plan.request.effort
    table = Table.grid(padding=(0, 2))
    table.add_column(style='dim')
    table.add_row('plan', f'{path}, method {effort.method}{search_text(effort)}')
    table.add_row(
        'viewpoints',
        f'{plan.viewpoint_count}, which see {100.0 * plan.covered_fraction:.1f} % '
        f'of {(plan.region_area_m2 - plan.forbidden_area_m2) / 1e4:.2f} ha',
    )
    if plan.forbidden_area_m2:
        table.add_row('exclusions', f'{plan.forbidden_area_m2 / 1e4:.2f} ha of the regions')
    unseen_m2 = (1.0 - plan.covered_fraction) * (plan.region_area_m2 - plan.forbidden_area_m2)
    if plan.largest_hole_m2:
        table.add_row(
            'unseen', f'{unseen_m2:.0f} m2, the largest part {plan.largest_hole_m2:.0f} m2'
        )
    above = f', at most {100.0 * plan.gap_fraction:.1f} % above optimal'
    table.add_row(
        'makespan',
        f'{clock(plan.makespan_s)}; no plan is shorter than '
        f'{clock(plan.lower_bound_s)} ({plan.lower_bound_method})'
        + (above if effort.minimises_makespan else ''),
    )
    if not effort.minimises_makespan:
        table.add_row(effort.objective, _objective_text(plan))
    table.add_row(
        'flown in all',
        f'{plan.total_length_m / 1000.0:.2f} km with {plan.total_energy_wh:.0f} Wh',
    )
    idle = [route.vehicle.name for route in plan.routes if not route.viewpoints]
    if idle:
        table.add_row('without a flight', ', '.join(idle))
    nearest = plan.minimum_separation_m
    if math.isfinite(nearest):
        text = f'{nearest:.1f} m between two vehicles in the air'
        remark = separation_remark(nearest, plan.request.separation.distance_m)
        table.add_row('nearest', text + remark)
    return table


def search_text(effort: Effort) -> str:
    """Return how long a search was, because 0 s means a number of steps."""
    if effort.method != METHODS[0]:
        return ''
    return f', {effort.budget_s:g} s' if effort.budget_s else ', a fixed number of steps'


def separation_remark(nearest_m: float, asked_m: float) -> str:
    """Return how to keep vehicles apart, or that some begin too near to be kept so."""
    if not asked_m:
        return '; --separation M keeps them apart'
    # What is in the air when a plan begins cannot wait on the ground.
    return f': NEARER than the {asked_m:g} m asked for' if nearest_m < asked_m - 0.05 else ''


def _objective_text(plan: SurveyPlan) -> str:
    """Return the value of an objective other than the makespan, and how good it is."""
    name, gap = plan.request.effort.objective, objective_gap(plan)
    proof = '' if math.isnan(gap) else f', at most {100.0 * gap:.1f} % above optimal'
    return f'{OBJECTIVE_VALUES[name](plan):.0f} {OBJECTIVE_UNITS[name]}{proof}'


def route_table(plan: SurveyPlan) -> Table:
    """Return a row for each vehicle."""
    table = Table(box=None, pad_edge=False, header_style='dim')
    for column in (
        'vehicle',
        'viewpoints',
        'flights',
        'length',
        'duration',
        'takes off',
        'height',
    ):
        table.add_column(column, justify='left' if column == 'vehicle' else 'right')
    for route in plan.routes:
        table.add_row(
            route.vehicle.name,
            str(len(route.viewpoints)),
            str(len(route.sorties)),
            f'{route.length_m:.0f} m',
            clock(route.duration_s),
            _take_off_text(route),
            f'{route.flight_height_m:.0f} m',
        )
    return table


def _take_off_text(route: Route) -> str:
    """Return when a vehicle takes off first."""
    if not route.sorties:
        return 'stays'
    return f'after {clock(route.delay_s)}' if route.delay_s else 'at once'
