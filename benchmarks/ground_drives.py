# SPDX-License-Identifier: Apache-2.0
"""Drives from survey to evidence and back, without processes: how the budget is kept.

    python benchmarks/ground_drives.py --run runs/evidence-... --count 500   readings to drive
    python benchmarks/ground_drives.py --run ... --results FILE --seconds 200   goes on each time
    python benchmarks/ground_drives.py --part wrong --count 1000             wrong predictions

`survey`: the drones' tracks and the mosaic are those of a run. For each seed the source has
another place (3 m about the wreck) and strength (half to twice), detectors count, the sources are
localised from these readings, the route is planned on that map, and the vehicle drives it
in the true field by its own readings.

`wrong`: random ways, 2 m or more from a source that is 0.3 to 6 times as strong as was planned
with.
"""

import argparse
import json
import math
import statistics
import sys
import tempfile
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from shapely import LineString, Point

from rocsafe_geo.motion.ground_motion import GroundMotion, Place
from rocsafe_geo.position import GeoPosition
from rocsafe_ground.dose.dose_field import dose_field
from rocsafe_ground.dose.source_posterior import read_sources
from rocsafe_ground.drivable.raster import read_bands
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveRequest
from rocsafe_ground.drive.ground_map import DOSES, SOURCES, GroundMap, MapFiles, read_ground_map
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.errors import GroundError
from rocsafe_ground.evidence.evidence_point import SOURCE, EvidencePoint
from rocsafe_radiation.localizer_options import LocalizerOptions
from rocsafe_radiation.products.assessment import assess
from rocsafe_radiation.products.files import write_products
from rocsafe_radiation.readings.reading_log import FlightReading, ReadingLog
from rocsafe_sim.driving.caution import CautionOptions
from rocsafe_sim.driving.chassis import Chassis, Skid
from rocsafe_sim.driving.drive_route import DrivenRoute, RouteStop
from rocsafe_sim.driving.drive_state import DriveOutcome, DriveState, Ledger
from rocsafe_sim.driving.rover import Rover
from rocsafe_sim.driving.rover_parts import RoverParts
from rocsafe_sim.sensors.sensing_noise import SensorNoise

Figures = dict[str, Any]
WRECK = GeoPosition(53.27985, -9.06330)
START = GeoPosition(53.27968, -9.06358)
WAGON = GeoPosition(53.27979, -9.06322)
AT_1M_USVH, BACKGROUND_USVH = 90_000.0, 0.1
# The router's wall of dose rate keeps ways so far from a source.
LEAST_DISTANCE_M = 2.0
# Of wrong predictions: lines between their stops, and the corner at which the vehicle stands.
PIECE_M, STAND_AFTER = 1.0, 2
# Upper 95 % of the dose over its mean, as it is stated there: of a well known source.
STATED_RATIO = 1.15
# Of a small counter on a drone.
CPS_PER_USVH = 10.0
SECOND = 1_000_000_000
STEP_NS = SECOND // 5


class TrueField:
    """A point source at the height of the detectors on the ground."""

    def __init__(self, place: Place, at_1m_usvh: float) -> None:
        self.place, self.at_1m_usvh = place, at_1m_usvh

    def rate(self, place: Place, up_m: float = 0.0) -> float:
        """Return the dose rate at a place, so much above the source."""
        square = (place[0] - self.place[0]) ** 2 + (place[1] - self.place[1]) ** 2 + up_m**2
        return BACKGROUND_USVH + self.at_1m_usvh / max(square, 0.01)


def drive(route: DrivenRoute, field: TrueField, seed: int) -> tuple[Rover, float]:
    """Return a vehicle after a drive in a field, and the dose that it took."""
    chassis = Chassis()
    noise = SensorNoise(
        seed=seed, vehicle='rgv1', gps_horizontal_std_m=0.02, gps_vertical_std_m=0.04,
        tilt_std_rad=0.0, attitude_std_rad=0.0,
    )  # fmt: skip
    parts = RoverParts(
        chassis=chassis, skid=Skid(chassis=chassis, seed=seed, vehicle='rgv1'), noise=noise,
        caution=CautionOptions(),
    )  # fmt: skip
    first = route.stops[0]
    state = DriveState(
        time_ns=0, east_m=first.east_m, north_m=first.north_m, charge_j=chassis.capacity_j,
        ledger=Ledger(),
    )  # fmt: skip
    rover = Rover(parts, state)
    rover.step(SECOND)
    rover.drive(route)
    dose, outcome = 0.0, None
    while not (rover.is_over and rover.is_idle):
        rover.step(rover.state.time_ns + STEP_NS)
        rate = field.rate(rover.state.place)
        dose += rate * STEP_NS / SECOND / 3600.0
        rover.read(rover.state.time_ns, rate)
        if rover.is_over and rover.state.ledger.outcome is DriveOutcome.DOSE_UNEXPECTED:
            # Nobody plans the rest anew: it comes home on its own tracks.
            outcome = rover.state.ledger.outcome
            rover.return_home()
    rover.state.ledger.outcome = outcome or rover.state.ledger.outcome
    return rover, dose


def part_wrong(count: int) -> Figures:
    """Drive random ways whose dose was predicted wrongly."""
    over, outcomes, largest = 0, dict[str, int](), 0.0
    for seed in range(count):
        generator = np.random.default_rng([seed, 0x57])
        places = [(0.0, 0.0), *generator.uniform(-30.0, 30.0, (4, 2)).tolist(), (0.0, 0.0)]
        places = [(float(east), float(north)) for east, north in places]
        way = LineString(places)
        place = next(
            one
            for one in generator.uniform(-30.0, 30.0, (100, 2)).tolist()
            if way.distance(Point(one)) >= LEAST_DISTANCE_M
        )
        true = TrueField((place[0], place[1]), 10.0 ** generator.uniform(3.0, 5.0))
        wrong = 0.3 * 20.0 ** generator.uniform()
        planned = TrueField(true.place, true.at_1m_usvh / wrong)
        route = wrong_route(places, planned, float(generator.uniform(1.05, 2.0)))
        rover, dose = drive(route, true, seed)
        share = dose / route.budget_usv
        largest = max(largest, share)
        over += share > 1.0
        name = (rover.state.ledger.outcome or DriveOutcome.COMPLETED).value
        outcomes[name] = outcomes.get(name, 0) + 1
    return {'drives': count, 'over_budget': int(over), 'largest_share': largest,
            'outcomes': outcomes}  # fmt: skip


def wrong_route(corners: list[Place], planned: TrueField, spare: float) -> DrivenRoute:
    """Return a way with a stand of 20 s in its middle, and a budget by what was planned.

    As in a plan, stops between the corners tell how the dose rate changes.
    """
    places, stand = [corners[0]], 0
    for number, (a, b) in enumerate(pairwise(corners)):
        count = math.ceil(math.dist(a, b) / PIECE_M)
        places += [
            (a[0] + k * (b[0] - a[0]) / count, a[1] + k * (b[1] - a[1]) / count)
            for k in range(1, count + 1)
        ]
        stand = len(places) - 1 if number == STAND_AFTER else stand
    looks = [0.0 if k == stand else None for k in range(len(places))]
    times = GroundMotion().durations_s(places, [1.0] * len(places), looks)
    stops = []
    for k, place in enumerate(places):
        before = places[max(k - 1, 0)]
        middle = (0.5 * (place[0] + before[0]), 0.5 * (place[1] + before[1]))
        rate = (planned.rate(before) + 4.0 * planned.rate(middle) + planned.rate(place)) / 6.0
        dwell = 20.0 if k == stand else 0.0
        dose = (times[k] * rate + dwell * planned.rate(place)) / 3600.0
        stops.append(
            RouteStop(
                east_m=place[0], north_m=place[1], limit_mps=1.0, dwell_s=dwell,
                evidence='e' if dwell else '', predicted_s=times[k] + dwell, predicted_usv=dose,
            )
        )  # fmt: skip
    budget = spare * sum(stop.predicted_usv for stop in stops)
    return DrivenRoute(
        route_id='wrong', stops=tuple(stops), budget_usv=budget, turn_back_usvh=1e5,
        upper_ratio=STATED_RATIO,
    )  # fmt: skip


def part_survey(run: Path, count: int, results: Path | None, seconds: float) -> Figures:
    """Survey, localise, plan and drive; seeds in the file of results are not run again."""
    ground = read_ground_map(MapFiles(folder=run), GroundVehicle(), 0.5, 1e5)
    track = drone_track(run)
    known = read_rows(results)
    begin = time.monotonic()
    for seed in range(count):
        if seed in known or time.monotonic() - begin > seconds:
            continue
        row = json.loads(json.dumps(one_run(ground, track, seed), default=float))
        known[seed] = row
        if results is not None:
            with results.open('a', encoding='utf-8') as stream:
                stream.write(json.dumps({'seed': seed, **row}) + '\n')
    rows = [known[seed] for seed in sorted(known) if seed < count]
    driven = [row for row in rows if 'dose' in row]
    return {
        'runs': len(rows),
        'planned': len(driven),
        'budget_kept': sum(bool(row['dose'] <= row['budget']) for row in driven),
        'completed': sum(row['outcome'] == 'completed' for row in driven),
        'inside_95_band': sum(bool(row['low'] <= row['dose'] <= row['high']) for row in driven),
        'time_within_5_percent': sum(abs(row['time_ratio'] - 1.0) <= 0.05 for row in driven),
        'time_ratio_median': statistics.median(row['time_ratio'] for row in driven),
        'dose_ratio_median': statistics.median(row['dose'] / row['mean'] for row in driven),
        'largest_share_of_budget': max(row['dose'] / row['budget'] for row in driven),
        'cpu_s_median': statistics.median(row['cpu_s'] for row in driven),
    }


def read_rows(results: Path | None) -> dict[int, Figures]:
    """Return the rows of a file of results by their seeds; a last line that is cut is left out."""
    found: dict[int, Figures] = {}
    if results is None or not results.is_file():
        return found
    for line in results.read_text(encoding='utf-8').splitlines():
        try:
            row = json.loads(line)
        except ValueError:
            continue
        found[row.pop('seed')] = row
    return found


def drone_track(run: Path) -> list[tuple[str, int, float, float, float]]:
    """Return vehicle, time, latitude, longitude, altitude of drones, one a second."""
    import csv

    rows, last = [], dict[str, int]()
    with (run / 'readings.csv').open(encoding='utf-8', newline='') as stream:
        for row in csv.DictReader(stream):
            vehicle, stamp = row['vehicle'], int(row['time_ns'])
            if vehicle.startswith('rav') and stamp - last.get(vehicle, 0) >= SECOND:
                last[vehicle] = stamp
                latitude, longitude = float(row['latitude_deg']), float(row['longitude_deg'])
                rows.append((vehicle, stamp, latitude, longitude, float(row['altitude_m'])))
    return rows


def one_run(ground: GroundMap, track: list[Any], seed: int) -> Figures:
    """Return the figures of one run."""
    begin = time.process_time()
    generator = np.random.default_rng([seed, 0x1E])
    grid = ground.grid
    wreck = grid.enu_of(WRECK)
    shift = generator.uniform(-3.0, 3.0, 2)
    true = TrueField(
        (wreck[0] + shift[0], wreck[1] + shift[1]),
        AT_1M_USVH * 2.0 ** generator.uniform(-1.0, 1.0),
    )
    options = LocalizerOptions(
        origin_latitude_deg=grid.origin.latitude_deg,
        origin_longitude_deg=grid.origin.longitude_deg, origin_altitude_m=66.0, model='paper',
    )  # fmt: skip
    log = options.log()
    count_readings(log, track, ground, true, generator)
    survey = log.survey()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found = assess(survey, options.assessment(log.models), log.vehicles)
        write_products(folder, found, log.frame)
        posterior = read_sources(folder / SOURCES)
        field = dose_field(read_bands(folder / DOSES), posterior, grid)
    known = replace(ground, field=field)
    plan = planned(known, posterior)
    if plan is None:
        return {'planned': False}
    rover, dose = drive(route_of(plan), true, seed)
    ledger = rover.state.ledger
    return {
        'dose': dose,
        'budget': plan.request.dose_budget_usv,
        'mean': plan.forecast.mean_usv,
        'low': plan.forecast.low_usv,
        'high': plan.forecast.high_usv,
        'outcome': (ledger.outcome or DriveOutcome.COMPLETED).value,
        'time_ratio': (ledger.ended_ns - ledger.began_ns) / SECOND / plan.time_s,
        'cpu_s': time.process_time() - begin,
    }


def count_readings(
    log: ReadingLog,
    track: list[Any],
    ground: GroundMap,
    true: TrueField,
    generator: np.random.Generator,
) -> None:
    """Add what counters on the drones read."""
    for vehicle, stamp, latitude, longitude, altitude in track:
        place = ground.grid.enu_of(GeoPosition(latitude, longitude))
        rate = true.rate(place, altitude - 67.0)
        counts = float(generator.poisson(rate * CPS_PER_USVH))
        read = counts / CPS_PER_USVH
        log.add(
            FlightReading(
                vehicle=vehicle, time_ns=stamp, latitude_deg=latitude, longitude_deg=longitude,
                altitude_m=altitude, dose_rate_usvh=read,
                dose_rate_std_usvh=math.sqrt(max(counts, 1.0)) / CPS_PER_USVH,
                counts=counts, live_time_s=1.0, window_s=1.0, model='paper',
            )
        )  # fmt: skip


def planned(ground: GroundMap, posterior: Any) -> DrivePlan | None:
    """Return a drive to a mark and to the sources, with a tenth more than the least budget."""
    evidence = [EvidencePoint(id='wagon', position=WAGON, dwell_s=20.0)]
    evidence += [
        EvidencePoint(id=f'source-{k}', position=source.position, kind=SOURCE)
        for k, source in enumerate(posterior.sources)
    ]
    request = DriveRequest(
        start=START, evidence=tuple(evidence[:3]), dose_budget_usv=1e9, curve_points=0
    )
    try:
        free = plan_drive(request, ground)
        return plan_drive(replace(request, dose_budget_usv=1.1 * free.forecast.upper_usv), ground)
    except GroundError:
        return None


def route_of(plan: DrivePlan) -> DrivenRoute:
    """Return a plan as the vehicle drives it."""
    return DrivenRoute(
        route_id='drive-1',
        stops=tuple(
            RouteStop(
                east_m=stop.east_m, north_m=stop.north_m, limit_mps=stop.speed_mps,
                dwell_s=stop.dwell_s, evidence=stop.evidence, look_rad=stop.look_rad,
                predicted_s=stop.duration_s, predicted_usv=stop.dose_usv,
            )
            for stop in plan.stops
        ),
        budget_usv=plan.request.dose_budget_usv,
        turn_back_usvh=plan.request.turn_back_usvh,
        upper_ratio=plan.forecast.upper_usv / plan.forecast.mean_usv,
    )  # fmt: skip


def main() -> int:
    """Run a part and print its figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--part', choices=('survey', 'wrong'), default='survey')
    parser.add_argument('--count', type=int, default=500)
    parser.add_argument('--run', type=Path, help='run directory with a mosaic and readings.csv')
    parser.add_argument(
        '--results', type=Path, help='file of rows, with which a later call goes on'
    )
    parser.add_argument('--seconds', type=float, default=math.inf, help='wall time for new seeds')
    options = parser.parse_args()
    if options.part == 'survey' and options.run is None:
        parser.error('--run is needed for the part survey')
    wrong = options.part == 'wrong'
    figures = (
        part_wrong(options.count)
        if wrong
        else part_survey(options.run, options.count, options.results, options.seconds)
    )
    sys.stdout.write(json.dumps({options.part: figures}, indent=1, default=float) + '\n')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
