# SPDX-License-Identifier: Apache-2.0
"""`replan_file`: plan the rest of a survey without ROS. One JSON request in, one summary out.

Example::

    {"plan": "out/plan.json", "visited": [0, 1, 2],
     "alive": [{"name": "rav1", "position": [53.28, -9.07], "used_s": 120.0}, {"name": "rav3"}],
     "new_places": [[53.2801, -9.063]], "new_exclusions": [{"polygon": [[53.2796, -9.0617], ...]}],
     "output_directory": "out/rest"}

A vehicle without a position stands at home; one that is not named is lost. `terrain_file` is that
of a plan over terrain.
Exit code 0; 2 with one line on standard error if the request is wrong or has no plan.
"""

import argparse
import json
import sys
from collections.abc import Sequence

from pydantic import Field, ValidationError

from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_planner.command_line.plan_command import EXIT_OK, EXIT_REFUSED, summary
from rocsafe_planner.command_line.request_json import (
    Place,
    StrictJson,
    ZoneJson,
    area_of,
    one_line,
    position_of,
)
from rocsafe_planner.errors import PlannerError
from rocsafe_planner.export.plan_reading import read_plan
from rocsafe_planner.problem.vehicle import Aloft
from rocsafe_planner.replanning import Situation, leaving_exclusions_m, replan, unreachable


class AliveJson(StrictJson):
    """A vehicle that can go on."""

    name: str
    position: Place | None = None
    used_s: float = 0.0


class ReplanJson(StrictJson):
    """The whole request; `output_directory` empty: no files are written."""

    plan: str
    alive: list[AliveJson]
    visited: list[int] = Field(default_factory=list)
    new_places: list[Place] = Field(default_factory=list)
    new_exclusions: list[ZoneJson] = Field(default_factory=list)
    terrain_file: str = ''
    output_directory: str = ''

    def situation(self) -> Situation:
        """Return the situation; ValueError naming the value and the limit."""
        return Situation(
            alive={vehicle.name: _aloft(vehicle) for vehicle in self.alive},
            visited=frozenset(self.visited),
            new_places=tuple(
                position_of(f'new_places.{number}', place)
                for number, place in enumerate(self.new_places)
            ),
            new_exclusions=tuple(
                area_of(f'new_exclusions.{number}', zone)
                for number, zone in enumerate(self.new_exclusions)
            ),
        )


def main(arguments: Sequence[str] | None = None) -> int:
    """Read, plan, write, and return the exit code."""
    argparse.ArgumentParser(
        prog='replan_file',
        description='Plan the rest of a survey: one JSON request in, a summary out.',
        epilog=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    ).parse_args(arguments)
    try:
        text = _replanned(sys.stdin.buffer.read().decode('utf-8', errors='replace'))
    except (PlannerError, ValueError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_REFUSED
    sys.stdout.write(text + '\n')
    return EXIT_OK


def _replanned(text: str) -> str:
    try:
        request = ReplanJson.model_validate_json(text)
    except ValidationError as error:
        raise ValueError(one_line(error)) from error
    terrain = read_terrain(request.terrain_file) if request.terrain_file else None
    plan = replan(read_plan(request.plan, terrain), request.situation())
    document = {
        **summary(plan, request.output_directory),
        'unreachable': list(unreachable(plan)),
        'leaving_exclusions_m': leaving_exclusions_m(plan),
    }
    return json.dumps(document, indent=1)


def _aloft(vehicle: AliveJson) -> Aloft | float:
    if vehicle.position is None:
        return vehicle.used_s
    place = position_of(f'{vehicle.name} position', vehicle.position)
    return Aloft(position=place, used_s=vehicle.used_s)


if __name__ == '__main__':
    raise SystemExit(main())
