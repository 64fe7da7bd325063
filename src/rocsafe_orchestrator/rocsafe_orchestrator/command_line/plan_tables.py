# SPDX-License-Identifier: Apache-2.0
"""A plan as tables on the console."""

from pathlib import Path
from typing import Any

from rich.table import Table

from rocsafe_orchestrator.command_line.progress import clock_text


def quality_table(path: Path, document: dict[str, Any]) -> Table:
    """Return what a plan is worth; `path` is what it was made from."""
    table = Table.grid(padding=(0, 2))
    table.add_column(style='dim')
    table.add_row('plan', f'{path}, method {document["method"]}')
    table.add_row(
        'viewpoints',
        f'{document["viewpoint_count"]}, which see {100.0 * document["covered_fraction"]:.1f} % '
        f'of {document["region_area_m2"] / 1e4:.2f} ha',
    )
    is_time = document['objective'] == 'longest_time'
    gap = f', at most {100.0 * document["gap_fraction"]:.1f} % above optimal' if is_time else ''
    table.add_row(
        'makespan',
        f'{clock_text(document["makespan_s"])}; no plan is shorter than '
        f'{clock_text(document["lower_bound_s"])} ({document["lower_bound_method"]}){gap}',
    )
    if not is_time:
        table.add_row(document['objective'], _objective_text(document))
    table.add_row(
        'flown in all',
        f'{document["total_length_m"] / 1000.0:.2f} km with {document["total_energy_wh"]:.0f} Wh',
    )
    nearest = document['minimum_separation_m']
    if nearest is not None:
        text = f'{nearest:.1f} m between two vehicles in the air'
        table.add_row('nearest', text + separation_remark(nearest, document['separation_m']))
    return table


def separation_remark(nearest_m: float, asked_m: float) -> str:
    """Return how to keep vehicles apart, or that some begin too near to be kept so."""
    if not asked_m:
        return '; --separation M keeps them apart'
    # What is in the air when a plan begins cannot wait on the ground.
    return f': NEARER than the {asked_m:g} m asked for' if nearest_m < asked_m - 0.05 else ''


def _objective_text(document: dict[str, Any]) -> str:
    """Return the value of an objective that is no makespan, and how good it is."""
    name, gap = document['objective'], document['objective_gap_fraction']
    unit = 'Wh' if name == 'energy' else 'm' if name.endswith('distance') else 's'
    proof = '' if gap is None else f', at most {100.0 * gap:.1f} % above optimal'
    return f'{document["objective_value"]:.0f} {unit}{proof}'


def route_table(document: dict[str, Any]) -> Table:
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
    for route in document['routes']:
        table.add_row(
            route['vehicle'],
            str(len(route['viewpoints'])),
            str(len(route['sorties'])),
            f'{route["length_m"]:.0f} m',
            clock_text(route['duration_s']),
            _take_off_text(route),
            f'{route["flight_height_m"]:.0f} m',
        )
    return table


def _take_off_text(route: dict[str, Any]) -> str:
    """Return when a vehicle takes off first."""
    if not route['sorties']:
        return 'stays'
    return f'after {clock_text(route["delay_s"])}' if route['delay_s'] else 'at once'
