# SPDX-License-Identifier: Apache-2.0
"""Compare recorded flights of a real autopilot with the model, the simulated vehicle and the plan.

    python benchmarks/flight_model.py

Each row is a survey that ArduCopter flew in its own simulator (see test/geo/recorded_surveys.py).
The columns are the time from its first waypoint to its last, recorded, by the model
(`rocsafe_geo.motion`), by a simulated vehicle of `rocsafe_sim`, and by the plan; the time of the
whole flight, from the command to standing motors, by vehicle and plan; and the mean current in the
survey. The exit code is 1 if a target is missed.
"""

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from rocsafe_geo.motion.battery import VOLTAGE_V
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_planner.plan.vehicle import Vehicle as PlannedVehicle
from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.route import FlightRoute, RouteWaypoint
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'test' / 'geo'))
from recorded_surveys import HEIGHT_M, RECORDED, Recorded

HOME = (0.0, 0.0, 0.0)
STEP_NS = NS_PER_S // 5
RECORDED_CURRENT_A = {'5 m/s': 28.0, '10 m/s': 28.7, 'wind 8 m/s from north': 29.4}
# Plan and flight are the same function of time; a flight is timed in whole nanoseconds.
AGREEMENT_S = 0.001
# Of the vehicle of ArduCopter's simulator, from its current in hover and its battery of 12.6 V.
RECORDED_HOVER_POWER_W = 350.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One survey: recorded, modelled, simulated and planned; times in seconds."""

    survey: Recorded
    model_s: float
    flown_s: float
    planned_s: float
    whole_flown_s: float
    whole_planned_s: float
    current_a: float

    @property
    def error(self) -> float:
        """Relative error of the simulated flight."""
        return float(self.flown_s / self.survey.recorded_s - 1.0)

    @property
    def is_met(self) -> bool:
        """Whether the targets are."""
        agree = max(
            abs(self.flown_s - self.model_s),
            abs(self.planned_s - self.model_s),
            abs(self.whole_flown_s - self.whole_planned_s),
        )
        return abs(self.error) <= self.survey.tolerance and agree <= AGREEMENT_S


def main() -> int:
    """Print the table; 1 if a target is missed."""
    rows = [_row(survey) for survey in RECORDED]
    _print(rows)
    return 0 if all(row.is_met for row in rows) else 1


def _row(survey: Recorded) -> Row:
    flown_s, whole_s, current_a = _flown(survey)
    planned_s, whole_planned_s = _planned(survey)
    return Row(
        survey=survey,
        model_s=survey.model_s(),
        flown_s=flown_s,
        planned_s=planned_s,
        whole_flown_s=whole_s,
        whole_planned_s=whole_planned_s,
        current_a=current_a,
    )


def _flown(survey: Recorded) -> tuple[float, float, float]:
    """Return survey time, whole time and mean current of a simulated flight."""
    airframe = Airframe(
        performance=survey.performance(),
        hover_s=0.0,
        endurance_s=3600.0,
        reserve_fraction=0.1,
        hover_power_w=RECORDED_HOVER_POWER_W,
    )
    vehicle = SimulatedVehicle(airframe, HOME)
    vehicle.step(NS_PER_S)
    waypoints = tuple(
        RouteWaypoint(viewpoint_id=number, position_enu=place, yaw_rad=0.0)
        for number, place in enumerate([(0.0, 0.0, HEIGHT_M), *survey.waypoints()])
    )
    vehicle.fly_route(FlightRoute(plan_id='recorded', home_enu=HOME, waypoints=waypoints))
    shots_ns, powers = [], []
    while (summary := vehicle.summary()) is None:
        seen = vehicle.step(vehicle.time_ns + STEP_NS)
        shots_ns += [shot.time_ns for shot in seen.shots]
        if 2 <= len(shots_ns) < len(waypoints):
            powers.append(seen.power_w)
    current_a = float(np.mean(powers)) / VOLTAGE_V
    return (shots_ns[-1] - shots_ns[1]) / NS_PER_S, summary.duration_s, current_a


def _planned(survey: Recorded) -> tuple[float, float]:
    """Return survey time and whole time in the planner."""
    flyer = survey.performance()
    vehicle = PlannedVehicle(
        name='rav1',
        home=GeoPosition(47.3977420, 8.5455940, 488.0),
        cruise_speed_mps=flyer.cruise_speed_mps,
        acceleration_mps2=flyer.acceleration_mps2,
        climb_rate_mps=flyer.climb_rate_mps,
        descent_rate_mps=flyer.descent_rate_mps,
        hover_s=0.0,
        endurance_s=3600.0,
        autopilot=flyer.autopilot,
    )
    points = np.array([(0.0, 0.0), *(place[:2] for place in survey.waypoints())])
    problem = FleetProblem(
        vehicles=(vehicle,),
        homes=np.zeros((1, 2)),
        points=points,
        height_m=HEIGHT_M,
        wind_mps=flyer.wind_mps,
    )
    command = list(range(len(points)))
    # two legs climb, one leads to the point above home
    arrivals = problem.motion(0, command).arrivals_s[2:]
    return arrivals[len(points) - 1] - arrivals[1], problem.duration_s(0, command)


def _print(rows: list[Row]) -> None:
    table = Table(title='Surveys by a real autopilot, by the model, in simulation and in the plan')
    for heading in (
        'survey', 'recorded s', 'model s', 'simulated s', 'plan s', 'error %', 'target %',
        'whole flight simulated s', 'planned s', 'current A', 'recorded A', '',
    ):  # fmt: skip
        table.add_column(heading, justify='left' if heading == 'survey' else 'right')
    for row in rows:
        known = RECORDED_CURRENT_A.get(row.survey.name, math.nan)
        table.add_row(
            row.survey.name,
            f'{row.survey.recorded_s:.1f}',
            *(f'{value:.2f}' for value in (row.model_s, row.flown_s, row.planned_s)),
            f'{100.0 * row.error:+.2f}',
            f'{100.0 * row.survey.tolerance:.0f}',
            f'{row.whole_flown_s:.2f}',
            f'{row.whole_planned_s:.2f}',
            f'{row.current_a:.1f}',
            '' if math.isnan(known) else f'{known:.1f}',
            'met' if row.is_met else 'MISSED',
        )
    Console(width=150).print(table)


if __name__ == '__main__':
    sys.exit(main())
