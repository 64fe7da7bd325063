# SPDX-License-Identifier: Apache-2.0
"""The command `ground`: a drive to evidence points, without ROS."""

import argparse
import dataclasses
import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from rocsafe_geo.evidence.evidence_log import LOG_NAME, EvidenceError
from rocsafe_geo.evidence.place_marks import PlaceMark, read_marks
from rocsafe_ground.command_line.ground_arguments import joined, parser
from rocsafe_ground.dose.toxic_load import PLUME, ZONES, GasExposure
from rocsafe_ground.drivable.labels import read_labels
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveRequest
from rocsafe_ground.drive.ground_map import (
    RELEASES,
    MapFiles,
    read_ground_map,
    read_posterior,
)
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.errors import GroundError, NoMapError
from rocsafe_ground.evidence.evidence_file import (
    FROM_MARKS,
    FROM_OBJECTS,
    FROM_RELEASES,
    evidence_of,
    place_of,
)
from rocsafe_ground.evidence.evidence_point import EvidencePoint
from rocsafe_ground.evidence.found_releases import found_releases
from rocsafe_ground.evidence.labelled_things import labelled_things
from rocsafe_ground.products.document import drive_document, duration_text
from rocsafe_ground.products.files import write_drive
from rocsafe_ground.tour.orders import MOST_POINTS

EXIT_OK, EXIT_NO_ROUTE, EXIT_REFUSED = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Read, plan, write, print, and return the exit code."""
    options = parser().parse_args(joined(sys.argv[1:] if arguments is None else arguments))
    try:
        plan, folder = _planned(options)
    except (NoMapError, ValueError, OSError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_REFUSED
    except GroundError as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_NO_ROUTE
    if options.json:
        sys.stdout.write(json.dumps(drive_document(plan), indent=1) + '\n')
    else:
        sys.stdout.write('\n'.join([*lines_of(plan), f'written to {folder}']) + '\n')
    return EXIT_OK


def _planned(options: argparse.Namespace) -> tuple[DrivePlan, Path]:
    files = MapFiles(
        labels=options.labels,
        folder=options.folder, dose_map=options.dose_map, sources=options.sources,
        terrain=options.terrain, keep_outs=tuple(options.keep_out),
    )  # fmt: skip
    names = [field.name for field in dataclasses.fields(GroundVehicle)]
    vehicle = GroundVehicle(**{name: getattr(options, name) for name in names})
    if not options.folder.is_dir():
        raise NoMapError(f'{options.folder}: no such folder')
    ground = read_ground_map(
        files, vehicle, options.cell, options.turn_back, options.turn_back_ppm
    )
    for word in ('load_budget', 'turn_back_ppm'):
        if math.isfinite(getattr(options, word)) and ground.gas is None:
            raise NoMapError(
                f'--{word.replace("_", "-")}: {options.folder} has no {PLUME} and {ZONES} of a '
                'release'
            )
    request = DriveRequest(
        start=place_of(options.start),
        evidence=evidence_of(
            options.to,
            read_posterior(files),
            _objects(options),
            _releases(options),
            _marks(options),
        ),
        dose_budget_usv=options.dose_budget,
        load_budget=options.load_budget,
        vehicle=vehicle,
        turn_back_usvh=options.turn_back,
        turn_back_ppm=options.turn_back_ppm,
        confidence=options.confidence,
    )
    plan = plan_drive(request, ground)
    folder = options.out or options.folder / 'ground'
    write_drive(folder, plan, ground)
    return plan, folder


def _objects(options: argparse.Namespace) -> list[EvidencePoint] | None:
    """Return the things that labels propose, as many as a tour takes beside the others."""
    if options.labels is None:
        return None
    room = MOST_POINTS - sum(text != FROM_OBJECTS for text in options.to)
    return labelled_things(read_labels(options.labels), max(room, 1))


def _marks(options: argparse.Namespace) -> list[PlaceMark]:
    """Return the places that operators marked in a run."""
    try:
        return read_marks(options.folder / LOG_NAME) if FROM_MARKS in options.to else []
    except EvidenceError as error:
        raise NoMapError(str(error)) from error


def _releases(options: argparse.Namespace) -> list[EvidencePoint] | None:
    """Return the releases that the survey found, None if it looked for none."""
    path = options.folder / RELEASES
    return found_releases(path) if FROM_RELEASES in options.to and path.is_file() else None


def lines_of(plan: DrivePlan) -> list[str]:
    """Return the drive in words."""
    forecast, request = plan.forecast, plan.request
    visited = ', '.join(stop.evidence for stop in plan.stops if stop.evidence)
    slower = plan.time_s / plan.fastest_s - 1.0
    kept = f'of {request.dose_budget_usv:.4g} uSv is kept with probability'
    gap = 100.0 * plan.gap_fraction
    moving, fastest = (usv - plan.standing_usv for usv in (forecast.mean_usv, plan.fastest_usv))
    times = fastest / max(moving, 1e-12)
    return [
        f'drive to {visited} and back: {plan.length_m:.0f} m in {duration_text(plan.time_s)}',
        (
            f'dose {forecast.mean_usv:.4g} uSv, {plan.standing_usv:.4g} of it at the evidence; '
            f'95 of 100 between {forecast.low_usv:.4g} and {forecast.high_usv:.4g}'
        ),
        f'the budget {kept} {forecast.probability:.3g}',
        (
            f'while it drives {moving:.4g} uSv; the fastest way {fastest:.4g} uSv, '
            f'{times:.3g} times as much, in {duration_text(plan.fastest_s)}: '
            f'this one takes {100.0 * slower:+.1f} % time'
            if slower > 0.0
            else f'while it drives {moving:.4g} uSv; no way to the same points is faster'
        ),
        (
            f'over cells {duration_text(plan.grid_time_s)}; no drive over them within the budget '
            f'is below {duration_text(plan.bound_s)} (gap {gap:.2f} %)'
        ),
        *_age(plan.oldest_s),
        *_gas(plan.gas),
        *_price(plan),
        *(f'left out: {one.evidence}: {one.why}' for one in plan.left_out),
        *_curve(plan),
    ]


def _age(oldest_s: float) -> list[str]:
    if not math.isfinite(oldest_s):
        return []
    age = duration_text(oldest_s)
    return [f'ground on the way was photographed up to {age} before the newest photograph']


def _gas(gas: GasExposure | None) -> list[str]:
    if gas is None:
        return []
    highest = f'{gas.highest_ppm:.3g} ppm at most, upper 95 % {gas.highest_upper_ppm:.3g}'
    load = 'its toxic load is not known'
    if math.isfinite(gas.load_share):
        load = (
            f'toxic load {gas.load_share:.3g} times that of {gas.level}, upper 95 % '
            f'{gas.load_upper_share:.3g} times'
        )
    outside = f'; {gas.unknown_s:.0f} s outside its map' if gas.unknown_s > 0.0 else ''
    return [f'{gas.agent}: {highest}; {load}{outside}']


def _price(plan: DrivePlan) -> list[str]:
    if plan.price_s_per_usv <= 0.0:
        return ['more dose would save no time']
    return [f'1 uSv more saves about {plan.price_s_per_usv:.3g} s']


def _curve(plan: DrivePlan) -> list[str]:
    if not plan.curve:
        return []
    # Where several budgets give the same time, only the least of them is printed.
    least = {duration_text(time): dose for dose, time in reversed(plan.curve)}
    rows = (f'  {dose:>10.4g} uSv  {time}' for time, dose in reversed(least.items()))
    return ['time by budget of dose, by the upper 95 %:', *rows]


if __name__ == '__main__':
    raise SystemExit(main())
