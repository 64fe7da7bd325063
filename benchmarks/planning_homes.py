# SPDX-License-Identifier: Apache-2.0
"""Fleets that take off and land at one place: what keeping apart costs, and what is proven.

    python benchmarks/planning_homes.py [--set develop|validate|open] [--count N] [--budget S]
        [--separation M]

Surveys are drawn by seed: rectangles of 60 to 400 m, 2 to 8 drones at one corner, or on a line
of pads 5 to 60 m apart. A seed below 100 is for developing, from 100 on for validating, from 200
on for the one opening at the end. Of each: the makespan with the separation, over the plan without
any, and over its own bound.
"""

import argparse
import math
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from rocsafe_geo.position import GeoPosition
from rocsafe_planner.errors import BeyondEnduranceError
from rocsafe_planner.plan.survey_options import Effort, SeparationOptions
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.region_plan import plan_region

SETS = {'develop': 0, 'validate': 100, 'open': 200}
LATITUDE_DEG, LONGITUDE_DEG = 53.28, -9.06
NORTH_M = 111_200.0
EAST_M = 111_320.0 * math.cos(math.radians(LATITUDE_DEG))


def place(east_m: float, north_m: float) -> GeoPosition:
    """Return the place so far from the corner of the region."""
    return GeoPosition(LATITUDE_DEG + north_m / NORTH_M, LONGITUDE_DEG + east_m / EAST_M)


def drawn(seed: int, path: Path) -> tuple[str, float, tuple[Vehicle, ...]]:
    """Write the region of a seed; return its name, the height of flight and the fleet."""
    generator = np.random.default_rng(seed)
    width_m, length_m = generator.uniform(60.0, 400.0, 2)
    angle = generator.uniform(0.0, math.pi)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    corners = np.array([[0, 0], [width_m, 0], [width_m, length_m], [0, length_m]]) @ turn
    places = [place(*corner) for corner in corners.tolist()]
    rows = [f'{one.latitude_deg:.7f},{one.longitude_deg:.7f}' for one in places]
    path.write_text('\n'.join(['latitude,longitude', *rows, '']), encoding='utf-8')
    count = int(generator.choice([2, 3, 4, 5, 6, 8]))
    height_m = float(generator.choice([25.0, 32.0, 40.0]))
    homes, kind = [places[0]] * count, 'one pad'
    if generator.random() < 0.4:
        step_m, way = generator.uniform(5.0, 60.0), generator.uniform(0.0, 2.0 * math.pi)
        east_m, north_m = generator.uniform(-80.0, 300.0, 2)
        homes = [
            place(east_m + k * step_m * math.cos(way), north_m + k * step_m * math.sin(way))
            for k in range(count)
        ]
        kind = f'pads {step_m:.0f} m apart'
    fleet = tuple(Vehicle(name=f'rav{k + 1}', home=home) for k, home in enumerate(homes))
    return f'{seed}: {width_m:.0f} x {length_m:.0f} m, {count} drones, {kind}', height_m, fleet


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--set', choices=SETS, default='develop')
    parser.add_argument('--count', type=int, default=20)
    parser.add_argument('--budget', type=float, default=0.0)
    parser.add_argument('--separation', type=float, default=SeparationOptions().distance_m)
    options = parser.parse_args()
    table = Table(title=f'Set {options.set}, {options.separation:g} m apart')
    for heading in ('survey', 'makespan s', 'over none %', 'over bound %', 'CPU s'):
        table.add_column(heading, justify='left' if heading == 'survey' else 'right')
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, 'region.csv')
        for seed in range(SETS[options.set], SETS[options.set] + options.count):
            name, height_m, fleet = drawn(seed, path)
            begun_s = time.process_time()
            try:
                plan, free = (
                    plan_region(
                        path,
                        height_agl_m=height_m,
                        vehicles=fleet,
                        effort=Effort(budget_s=options.budget),
                        separation=SeparationOptions(distance_m=distance_m),
                    )
                    for distance_m in (options.separation, 0.0)
                )
            except BeyondEnduranceError:
                continue
            spent_s = time.process_time() - begun_s
            row = (
                plan.makespan_s,
                100.0 * (plan.makespan_s / free.makespan_s - 1.0),
                100.0 * (plan.makespan_s / plan.lower_bound_s - 1.0),
                spent_s,
            )
            rows.append(row)
            table.add_row(name, *(f'{value:.1f}' for value in row))
            print(name, *(f'{value:.1f}' for value in row), file=sys.stderr, flush=True)
    for heading, figure in (('median', np.median), ('worst', np.max)):
        table.add_row(heading, *(f'{value:.1f}' for value in figure(np.array(rows), axis=0)))
    Console(width=110).print(table)
    return 0


if __name__ == '__main__':
    sys.exit(main())
