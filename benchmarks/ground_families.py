# SPDX-License-Identifier: Apache-2.0
"""Drives over drawn places, from survey to evidence and back, without files of a run.

    python benchmarks/ground_families.py --seeds 0:200 --results FILE --seconds 300

Each seed draws a place of 110 x 110 m (classes of ground, obstacles), one or two sources, a survey
by one drone, the start and one to three points of evidence, and a budget of 0.8 to 1.5 times what
the fastest drive is sure to keep. Every family differs in one thing: `open` few obstacles, `woods`
many, `hills` slopes of up to 15 degrees, `clutter` things that the map does not show. Sources are
localised from the counts of the drone, the route is planned on that map and driven in the true
field by readings with counting noise; what ends on the way is planned anew, as in a mission.
"""

import argparse
import json
import math
import statistics
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from ground import smooth
from ground_drives import CPS_PER_USVH, SECOND, STEP_NS, read_rows, route_of
from scipy.ndimage import distance_transform_edt

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_ground.dose.dose_field import dose_field
from rocsafe_ground.dose.source_posterior import read_sources
from rocsafe_ground.drivable.drivable_ground import DrivableGround, Reason, is_near
from rocsafe_ground.drivable.raster import read_bands
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveRequest
from rocsafe_ground.drive.ground_map import DOSES, SOURCES, GroundMap
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.errors import GroundError
from rocsafe_ground.evidence.evidence_point import SOURCE, EvidencePoint
from rocsafe_radiation.localizer_options import LocalizerOptions
from rocsafe_radiation.products.assessment import assess
from rocsafe_radiation.products.files import write_products
from rocsafe_radiation.readings.reading_log import FlightReading
from rocsafe_sim.driving.caution import CautionOptions
from rocsafe_sim.driving.chassis import Chassis, Skid
from rocsafe_sim.driving.drive_state import DriveOutcome, DriveState, Ledger
from rocsafe_sim.driving.rover import Rover
from rocsafe_sim.driving.rover_parts import RoverParts
from rocsafe_sim.sensors.sensing_noise import SensorNoise

Figures = dict[str, Any]
FAMILIES = ('open', 'woods', 'hills', 'clutter')
ORIGIN = GeoPosition(53.28, -9.06, 66.0)
CELLS, CELL_M = 220, 0.5
HALF_M = 0.5 * CELLS * CELL_M
BACKGROUND_USVH, TURN_BACK_USVH = 0.1, 1e5
MOST_PLANS, AMPLE_USV = 5, 1e9
VEHICLE = GroundVehicle()
OUT = (DriveOutcome.BLOCKED, DriveOutcome.DOSE_UNEXPECTED)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Place:
    """What a seed draws: ground, things on it, and sources (east, north, up, rate at 1 m)."""

    family: str
    seed: int
    grid: RouteGrid
    ground: DrivableGround
    heights_m: FloatArray
    clear_m: FloatArray
    sources: FloatArray

    def rate(self, place: Iterable[float], up_m: float = 1.0) -> float:
        """Return the true dose rate at a place, so much above the ground."""
        offsets = self.sources[:, :3] - np.array([*place, up_m])
        squares = np.maximum((offsets**2).sum(axis=1), 0.01)
        return BACKGROUND_USVH + float((self.sources[:, 3] / squares).sum())

    def ground_up_m(self, east_m: float, north_m: float) -> float:
        """Return the height of the ground."""
        return between(self.heights_m, east_m, north_m)

    def touched(self, place: tuple[float, float, float], radius_m: float) -> str:
        """Return what a ball touches."""
        return 'a thing' if between(self.clear_m, place[0], place[1]) < radius_m else ''

    def first_hit_m(self, *_: Any) -> float:
        """Return that nothing is hit."""
        return math.inf


def between(values: FloatArray, east_m: float, north_m: float) -> float:
    """Return a value at a place, bilinear between the middles of cells."""
    x, y = (min(max((at + HALF_M) / CELL_M - 0.5, 0.0), CELLS - 1.001) for at in (east_m, north_m))
    column, row = int(x), int(y)
    near = values[row : row + 2, column : column + 2]
    west, east = near[0] + (y - row) * (near[1] - near[0])
    return float(west + (x - column) * (east - west))


def drawn_place(seed: int) -> Place:
    """Return the place of a seed."""
    rng = np.random.default_rng([seed, 0xFA])
    family = FAMILIES[seed % len(FAMILIES)]
    grid = RouteGrid(origin=ORIGIN, west_m=-HALF_M, south_m=-HALF_M, cell_m=CELL_M,
                     rows=CELLS, columns=CELLS)  # fmt: skip
    known = drawn_things(rng, grid, 90 if family == 'woods' else 15, (0.6, 4.0))
    hidden = drawn_things(rng, grid, 40 if family == 'clutter' else 0, (0.3, 0.8))
    heights: FloatArray = np.zeros(grid.shape)
    if family == 'hills':
        heights = smooth(rng, CELLS, 20)
        steepest = np.hypot(*np.gradient(heights, CELL_M)).max()
        heights *= math.tan(math.radians(rng.uniform(5.0, 15.0))) / steepest
    reasons = np.where(known, Reason.OBSTACLE, Reason.FREE).astype(np.uint8)
    near = is_near(known, CELL_M, VEHICLE.kept_m(CELL_M))
    reasons[near & ~known] = Reason.TOO_NEAR
    kinds = np.digitize(smooth(rng, CELLS, 8), (0.35, 0.65))
    speeds = np.array([VEHICLE.rough_mps, VEHICLE.grass_mps, VEHICLE.road_mps])[kinds]
    slope = np.arctan(np.hypot(*np.gradient(heights, CELL_M)))
    share = 1.0 - 0.6 * slope / math.radians(VEHICLE.largest_slope_deg)
    count = 1 + (rng.random() < 0.25)
    sources = np.column_stack([
        rng.uniform(-0.6 * HALF_M, 0.6 * HALF_M, (count, 2)), rng.uniform(0.3, 1.5, count),
        10.0 ** rng.uniform(3.5, 5.0, count),
    ])  # fmt: skip
    clear_m = (distance_transform_edt(~(known | hidden)) - 0.5) * CELL_M
    return Place(
        family=family, seed=seed, grid=grid, heights_m=heights, sources=sources, clear_m=clear_m,
        ground=DrivableGround(reasons=reasons, slowness_spm=1.0 / (speeds * share)),
    )  # fmt: skip


def drawn_things(
    rng: np.random.Generator, grid: RouteGrid, count: int, radii: tuple[float, float]
) -> BoolArray:
    """Return the cells of round things."""
    east, north = grid.places()
    found = np.zeros(grid.shape, np.bool_)
    for _ in range(count):
        x, y = rng.uniform(-HALF_M, HALF_M, 2)
        found |= np.hypot(east - x, north - y) < rng.uniform(*radii)
    return found


def surveyed(place: Place) -> GroundMap:
    """Return the map after one drone has flown over the place in lanes, with a small counter."""
    rng = np.random.default_rng([place.seed, 0xFB])
    height, lane, speed = rng.uniform(20, 40), rng.uniform(12, 22), rng.uniform(4, 8)
    options = LocalizerOptions(
        origin_latitude_deg=ORIGIN.latitude_deg, origin_longitude_deg=ORIGIN.longitude_deg,
        origin_altitude_m=ORIGIN.altitude_m, model='paper',
    )  # fmt: skip
    log = options.log()
    frame = LocalFrame(ORIGIN)
    # Of the counter: what the localizer allows for.
    response = CPS_PER_USVH * rng.normal(1.0, 0.05)
    for number, (east, north) in enumerate(lanes(lane, speed)):
        fix = frame.position_of([east, north, height])
        counts = float(rng.poisson(place.rate((east, north), height) * response))
        log.add(
            FlightReading(
                vehicle='rav1', time_ns=number * SECOND, latitude_deg=fix.latitude_deg,
                longitude_deg=fix.longitude_deg, altitude_m=fix.altitude_m,
                dose_rate_usvh=counts / CPS_PER_USVH,
                dose_rate_std_usvh=math.sqrt(max(counts, 1.0)) / CPS_PER_USVH,
                counts=counts, live_time_s=1.0, window_s=1.0, model='paper',
            )
        )  # fmt: skip
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = assess(log.survey(), options.assessment(log.models), log.vehicles)
        write_products(folder, found, frame)
        field = dose_field(read_bands(folder / DOSES), read_sources(folder / SOURCES), place.grid)
    return GroundMap(
        grid=place.grid, ground=place.ground, field=field, turn_back_usvh=TURN_BACK_USVH
    )


def lanes(lane_m: float, speed_mps: float) -> Iterator[tuple[float, float]]:
    """Yield the place of a drone at each second."""
    for k, north in enumerate(np.arange(-HALF_M + 0.5 * lane_m, HALF_M, lane_m)):
        for along in np.arange(-HALF_M, HALF_M, speed_mps):
            yield float(along if k % 2 == 0 else -along), float(north)


def first_request(place: Place, ground: GroundMap) -> DriveRequest | None:
    """Return what is asked: a drawn start, marks, what was found, and a budget; None: no way."""
    rng = np.random.default_rng([place.seed, 0xFC])
    free = np.flatnonzero(ground.is_free)
    spots = place.grid.place_of(rng.choice(free, 3)).tolist()
    start, *marks = (place.grid.position_at(*spot) for spot in spots)
    evidence = [
        EvidencePoint(id=f'mark-{k}', position=mark, dwell_s=float(rng.uniform(5, 40)))
        for k, mark in enumerate(marks[: int(rng.integers(1, 3))])
    ]
    posterior = ground.field.posterior
    evidence += [
        EvidencePoint(id=f'source-{k}', position=source.position, kind=SOURCE)
        for k, source in enumerate(posterior.sources if posterior else ())
    ]
    request = DriveRequest(
        start=start, evidence=tuple(evidence[:4]), dose_budget_usv=AMPLE_USV, curve_points=0
    )
    try:
        upper = plan_drive(request, ground).forecast.upper_usv
    except GroundError:
        return None
    return replace(request, dose_budget_usv=max(upper, 0.01) * float(rng.uniform(0.8, 1.5)))


def new_rover(place: Place, plan: DrivePlan) -> Rover:
    """Return a vehicle at the start of a plan."""
    chassis = Chassis()
    noise = SensorNoise(
        seed=place.seed, vehicle='rgv1', gps_horizontal_std_m=0.02, gps_vertical_std_m=0.04,
        tilt_std_rad=0.0, attitude_std_rad=0.0,
    )  # fmt: skip
    parts = RoverParts(
        chassis=chassis, skid=Skid(chassis=chassis, seed=place.seed, vehicle='rgv1'), noise=noise,
        caution=CautionOptions(), surroundings=place,
    )  # fmt: skip
    first = plan.stops[0]
    state = DriveState(
        time_ns=0, east_m=first.east_m, north_m=first.north_m, charge_j=chassis.capacity_j,
        ledger=Ledger(),
    )  # fmt: skip
    rover = Rover(parts, state)
    rover.step(SECOND)
    return rover


def driven(rover: Rover, place: Place, plan: DrivePlan | None, rng: Any) -> tuple[float, float]:
    """Drive a plan, or on; return the true dose and the highest true dose rate."""
    if plan is not None:
        rover.drive(route_of(plan))
    dose, highest = 0.0, 0.0
    window = CPS_PER_USVH * STEP_NS / SECOND
    while not (rover.is_over and rover.is_idle):
        rover.step(rover.state.time_ns + STEP_NS)
        rate = place.rate(rover.state.place)
        dose, highest = dose + rate * STEP_NS / SECOND / 3600.0, max(highest, rate)
        rover.read(rover.state.time_ns, float(rng.poisson(rate * window)) / window)
    return dose, highest


def one_run(seed: int) -> Figures:
    """Return the figures of a seed."""
    begin = time.process_time()
    place = drawn_place(seed)
    ground = surveyed(place)
    asked = first_request(place, ground)
    if asked is None:
        return {'family': place.family, 'planned': False}
    try:
        plan = plan_drive(asked, ground)
    except GroundError as error:
        return {'family': place.family, 'planned': False, 'why': str(error)}
    rng = np.random.default_rng([seed, 0xFD])
    rover = new_rover(place, plan)
    row = first_figures(place, plan, asked)
    dose, highest, outcomes = drive_all(rover, place, ground, (asked, plan), rng)
    ledger = rover.state.ledger
    return row | {
        'dose': dose, 'highest': highest, 'outcomes': outcomes,
        'cpu_s': time.process_time() - begin, 'time_s': (ledger.ended_ns - SECOND) / SECOND,
    }  # fmt: skip


def first_figures(place: Place, plan: DrivePlan, asked: DriveRequest) -> Figures:
    """Return what is known before the drive, and what the plan takes in the true field."""
    track = plan.track
    rates = np.array([place.rate(spot) for spot in track[:, :2]])
    dose = float(np.trapezoid(rates, track[:, 2]) / 3600.0)
    cast = plan.forecast
    return {
        'family': place.family, 'sources': len(place.sources), 'budget': asked.dose_budget_usv,
        'mean': cast.mean_usv, 'low': cast.low_usv, 'high': cast.high_usv,
        'upper': cast.upper_usv, 'planned_s': plan.time_s, 'true_plan': dose,
        'gap': plan.gap_fraction, 'left_out': len(plan.left_out),
    }  # fmt: skip


def drive_all(
    rover: Rover, place: Place, ground: GroundMap, first: tuple[DriveRequest, DrivePlan], rng: Any
) -> tuple[float, float, list[str]]:
    """Drive, and plan the rest anew while the vehicle is on its way."""
    asked, plan = first
    total, peak, outcomes = 0.0, 0.0, list[str]()
    blocked: tuple[GeoPosition, ...] = ()
    taken: set[str] = set()
    for _ in range(MOST_PLANS):
        dose, highest = driven(rover, place, plan, rng)
        total, peak = total + dose, max(peak, highest)
        ledger = rover.state.ledger
        outcomes.append((ledger.outcome or DriveOutcome.COMPLETED).value)
        if ledger.outcome not in OUT:
            return total, peak, outcomes
        taken |= set(ledger.evidence)
        blocked = (*blocked, *(place.grid.position_at(*one) for one in ledger.blocked))
        left = tuple(one for one in asked.evidence if one.id not in taken)
        rest = asked.dose_budget_usv - total
        if not left or rest <= 0.0:
            break
        try:
            plan = plan_drive(
                replace(asked, start=place.grid.position_at(*rover.state.place), end=asked.start,
                        evidence=left, dose_budget_usv=rest, blocked=blocked), ground,
            )  # fmt: skip
        except GroundError:
            break
    rover.return_home()
    dose, highest = driven(rover, place, None, rng)
    return total + dose, max(peak, highest), [*outcomes, 'came home on its tracks']


def summary(rows: list[Figures]) -> Figures:
    """Return shares over runs."""
    rows = [row for row in rows if 'dose' in row]
    whole = [row for row in rows if row['outcomes'] == ['completed']]
    ratios = [row['time_s'] / row['planned_s'] for row in whole]
    return {
        'driven': len(rows),
        'budget_kept': sum(row['dose'] <= row['budget'] for row in rows),
        'largest_share_of_budget': max(row['dose'] / row['budget'] for row in rows),
        'plan_would_keep': sum(row['true_plan'] <= row['budget'] for row in rows),
        'wall_passed': sum(row['highest'] >= TURN_BACK_USVH for row in rows),
        'in_band_of_plan': sum(row['low'] <= row['true_plan'] <= row['high'] for row in rows),
        'completed_at_once': len(whole),
        'in_band_of_these': sum(row['low'] <= row['dose'] <= row['high'] for row in whole),
        'time_within_5_percent': sum(abs(ratio - 1.0) <= 0.05 for ratio in ratios),
        'time_ratio_median': statistics.median(ratios) if ratios else None,
        'time_ratio_ends': [min(ratios), max(ratios)] if ratios else None,
        'needless_turn_backs': sum(
            'turned back for its dose' in row['outcomes'] and row['true_plan'] <= row['budget']
            for row in rows
        ),
        'collisions': sum('collided' in row['outcomes'] for row in rows),
        'cpu_s_median': statistics.median(row['cpu_s'] for row in rows),
    }


def main() -> int:
    """Run seeds that the file of results does not have, and print figures of each family."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--seeds', default='0:500', help='first and last + 1 (default: 0:500)')
    parser.add_argument('--results', type=Path, help='file of rows, with which a call goes on')
    parser.add_argument('--seconds', type=float, default=math.inf, help='wall time for new seeds')
    options = parser.parse_args()
    first, last = (int(part) for part in options.seeds.split(':'))
    known, begin = read_rows(options.results), time.monotonic()
    for seed in range(first, last):
        if seed in known or time.monotonic() - begin > options.seconds:
            continue
        known[seed] = json.loads(json.dumps(one_run(seed), default=float))
        if options.results is not None:
            with options.results.open('a', encoding='utf-8') as stream:
                stream.write(json.dumps({'seed': seed, **known[seed]}) + '\n')
    rows = [known[seed] for seed in sorted(known) if first <= seed < last]
    shown: Figures = {'not planned': sum('dose' not in row for row in rows)}
    for family in FAMILIES:
        if chosen := [row for row in rows if row['family'] == family and 'dose' in row]:
            shown[family] = summary(chosen)
    if any('dose' in row for row in rows):
        shown['all'] = summary(rows)
    sys.stdout.write(json.dumps(shown, indent=1) + '\n')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
