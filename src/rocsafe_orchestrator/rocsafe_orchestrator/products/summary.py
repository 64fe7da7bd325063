# SPDX-License-Identifier: Apache-2.0
"""The figures of a run: planned, flown, measured, missing."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from typing import Any

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.storage.json_values import finite
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.products.release_estimates import ReleaseEstimates
from rocsafe_orchestrator.products.run_record import (
    STATE_NAMES,
    MissionSample,
    Reading,
    RunRecord,
    VehicleSample,
)
from rocsafe_orchestrator.products.separation import (
    Nearest,
    airborne_spans_ns,
    nearest_in_the_air,
)
from rocsafe_orchestrator.products.source_estimates import SourceEstimates
from rocsafe_orchestrator.products.viewpoint_balance import viewpoint_balance
from rocsafe_planner.plan.plan import Route, SurveyPlan
from rocsafe_scenario.scenario import Scenario

S_PER_H = 3600.0
_PLAN_FIGURES = (
    'makespan_s', 'lower_bound_s', 'lower_bound_method', 'gap_fraction', 'region_area_m2',
    'covered_area_m2', 'covered_fraction', 'viewpoint_count', 'spacing_m',
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class HighestReading:
    """The highest dose rate measured, with where and when.

    `height_agl_m` is None where the height of the ground is not known.
    """

    dose_rate_usvh: float
    vehicle: str
    time: str
    time_ns: int
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    height_agl_m: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleFigures:
    """Figures of one vehicle; None if unknown.

    Attributes
    ----------
    is_ground_vehicle
        Whether it drives; what is said of flights holds for its drive.
    flown_duration_s
        Take-off to touch-down, or to the last message.
    planned_duration_s, planned_length_m
        Of its route; None if it flew more than one plan.
    viewpoints_planned
        Viewpoints of all plans; of a replaced plan, those visited before.
    integrated_dose_usv
        Dose of the vehicle, microsievert, by the trapezoidal rule over its readings.
    """

    name: str
    is_ground_vehicle: bool
    planned_duration_s: float | None
    flown_duration_s: float | None
    planned_length_m: float | None
    flown_length_m: float | None
    viewpoints_planned: int | None
    viewpoints_visited: int | None
    images_stored: int
    reading_count: int
    highest_dose_rate_usvh: float | None
    integrated_dose_usv: float | None
    battery_left_fraction: float | None
    state: str


@dataclass(frozen=True, slots=True, kw_only=True)
class RunSummary:
    """All figures of a run, as in ``summary.json``; None if unknown.

    Attributes
    ----------
    outcome
        ``complete``, ``failed``, ``cancelled`` or ``unknown``.
    mission_duration_s
        First take-off to the end of the last flight or drive, simulated.
    wall_time_s
        Seconds from the command to the report.
    start_up_s
        Wall time from the start of the run to the first take-off.
    real_time_factor
        Simulated time over wall time while flying.
    images_expected, viewpoints_photographed
        Viewpoints of all plans, each counted once, and those of them with a photograph.
    processes_restarted
        Process to number of restarts.
    lost_vehicles
        Vehicles lost in flight, and why.
    estimates
        Sources estimated from the readings.
    releases
        Releases of gas estimated from the readings.
    nearest
        The least distance of any two vehicles in the air.
    missing
        One line for each missing part.
    """

    run: str
    scenario: str
    description: str
    seed: int | None
    outcome: str
    outcome_text: str
    plan: SurveyPlan | None
    vehicles: tuple[VehicleFigures, ...]
    images_stored: int
    images_expected: int | None
    viewpoints_photographed: int
    reading_count: int
    highest_reading: HighestReading | None
    integrated_dose_usv: float | None
    estimates: SourceEstimates | None
    releases: ReleaseEstimates | None
    mission_duration_s: float | None
    wall_time_s: float | None
    start_up_s: float | None
    real_time_factor: float | None
    message_count: int | None
    nearest: Nearest | None
    processes_restarted: Mapping[str, int]
    lost_vehicles: Mapping[str, str]
    versions: Mapping[str, str]
    missing: tuple[str, ...]

    def to_plain(self) -> dict[str, Any]:
        """Return values that JSON can hold; what is not finite becomes None."""
        figures = _plan_figures(self.plan) if self.plan else None
        plain = {**dataclasses.asdict(dataclasses.replace(self, plan=None)), 'plan': figures}
        if self.releases is not None:
            plain['releases'].pop('figure')
        return dict(finite(plain))


def summarise(record: RunRecord) -> RunSummary:
    """Return the figures of the run that `record` describes."""
    log = record.log
    readings = log.readings if log else ()
    mission = log.mission if log else ()
    vehicles = tuple(_vehicle_figures(record, name) for name in record.vehicles)
    doses = [v.integrated_dose_usv for v in vehicles if v.integrated_dose_usv is not None]
    outcome, text = _outcome(record.info, mission)
    balance = viewpoint_balance(record.plans, record.photographs)
    return RunSummary(
        run=record.path.name,
        scenario=record.scenario.name if record.scenario else record.path.name,
        description=record.scenario.description if record.scenario else '',
        seed=record.scenario.seed if record.scenario else None,
        outcome=outcome,
        outcome_text=text,
        plan=record.plan,
        vehicles=vehicles,
        images_stored=len(record.photographs),
        images_expected=balance.planned if record.plan and record.has_cameras else None,
        viewpoints_photographed=balance.photographed,
        reading_count=len(readings),
        highest_reading=_over_ground(highest_reading(readings), record.scenario),
        integrated_dose_usv=math.fsum(doses) if doses else None,
        estimates=record.estimates,
        releases=record.releases,
        mission_duration_s=_mission_duration_s(record),
        wall_time_s=_wall_time_s(record.info, mission),
        start_up_s=_start_up_s(mission),
        real_time_factor=_real_time_factor(mission),
        message_count=log.facts.message_count if log else None,
        nearest=nearest_in_the_air(log) if log else None,
        processes_restarted=_restarts(record.info),
        lost_vehicles=_lost(record.info),
        versions=_versions(record.info),
        missing=record.missing,
    )


def highest_reading(readings: Sequence[Reading]) -> HighestReading | None:
    """Return the highest of `readings`, the earliest if several are equal."""
    if not readings:
        return None
    top = max(readings, key=lambda reading: (reading.dose_rate_usvh, -reading.time_ns))
    return HighestReading(
        dose_rate_usvh=top.dose_rate_usvh,
        vehicle=top.vehicle,
        time=utc_text(top.time_ns),
        time_ns=top.time_ns,
        latitude_deg=top.latitude_deg,
        longitude_deg=top.longitude_deg,
        altitude_m=top.altitude_m,
    )


def integrated_dose_usv(readings: Sequence[Reading]) -> float | None:
    """Return the dose in microsievert along `readings` of one vehicle, by trapezoids."""
    if len(readings) < 2:
        return None
    seconds = np.array([reading.time_ns for reading in readings], dtype=np.int64) / NS_PER_S
    rates = np.array([reading.dose_rate_usvh for reading in readings])
    return float(np.sum(np.diff(seconds) * (rates[1:] + rates[:-1])) / 2.0 / S_PER_H)


def flight_ns(samples: Sequence[VehicleSample]) -> tuple[int, int] | None:
    """Return when a vehicle took off first and was on the ground again, None if it never flew.

    A vehicle that was never seen to land counts as flying until its last message.
    """
    spans = airborne_spans_ns(samples)
    return (spans[0][0], spans[-1][1]) if spans else None


def viewpoints_of(
    samples: Sequence[VehicleSample], route: Route | None
) -> tuple[int | None, int | None]:
    """Return the number of viewpoints visited and planned; None if unknown.

    `samples` cover every plan that it flew; `route` is used if it received none.
    """
    plans = {sample.plan_id: sample for sample in samples if sample.plan_id}
    if not plans:
        return 0 if samples else None, len(route.viewpoints) if route else None
    *replaced, last = plans.values()
    before = sum(sample.viewpoints_visited for sample in replaced)
    return before + last.viewpoints_visited, before + last.viewpoint_count


def utc_text(time_ns: int) -> str:
    """Return `time_ns`, nanoseconds since 1970, as ISO 8601 in UTC with milliseconds."""
    moment = datetime.fromtimestamp(time_ns // NS_PER_S, tz=timezone.utc)
    milliseconds = time_ns % NS_PER_S // 1_000_000
    return f'{moment:%Y-%m-%dT%H:%M:%S}.{milliseconds:03d}Z'


def _outcome(info: Mapping[str, object], mission: Sequence[MissionSample]) -> tuple[str, str]:
    """Return the outcome and its reason, from ``run.json`` or else from the recording."""
    if isinstance(info.get('outcome'), str):
        return str(info['outcome']), str(info.get('outcome_text') or '')
    if mission and mission[-1].phase.is_over:
        return mission[-1].phase.name.lower(), mission[-1].text
    last = f'the recording ends while {mission[-1].phase.name.lower()}' if mission else ''
    return 'unknown', last


def _plan_figures(plan: SurveyPlan) -> dict[str, object]:
    """Return how good the plan is; the keys mean what the fields of ``SurveyPlan.msg`` do."""
    return {
        'method': plan.request.effort.method,
        **{name: getattr(plan, name) for name in _PLAN_FIGURES},
        'height_agl_m': plan.request.coverage.height_agl_m,
        'separation_m': plan.request.separation.distance_m,
        'minimum_separation_m': plan.minimum_separation_m,
    }


def _vehicle_figures(record: RunRecord, name: str) -> VehicleFigures:
    route = _route_of(record.plan, name)
    samples = record.log.samples.get(name, ()) if record.log else ()
    is_replanned = len({sample.plan_id for sample in samples} - {''}) > 1
    readings = [r for r in record.log.readings if r.vehicle == name] if record.log else []
    flight = flight_ns(samples)
    last = samples[-1] if samples else None
    visited, planned = viewpoints_of(samples, route)
    return VehicleFigures(
        name=name,
        is_ground_vehicle=name == record.driver,
        planned_duration_s=route.duration_s if route and not is_replanned else None,
        flown_duration_s=(flight[1] - flight[0]) / NS_PER_S if flight else None,
        planned_length_m=route.length_m if route and not is_replanned else None,
        flown_length_m=last.distance_flown_m if last else None,
        viewpoints_planned=planned,
        viewpoints_visited=visited,
        images_stored=sum(shot.vehicle == name for shot in record.photographs),
        reading_count=len(readings),
        highest_dose_rate_usvh=max((r.dose_rate_usvh for r in readings), default=None),
        integrated_dose_usv=integrated_dose_usv(readings),
        battery_left_fraction=last.battery_fraction if last else None,
        state=STATE_NAMES[last.state] if last else STATE_NAMES[0],
    )


def _route_of(plan: SurveyPlan | None, vehicle: str) -> Route | None:
    routes = plan.routes if plan else ()
    return next((route for route in routes if route.vehicle.name == vehicle), None)


def _mission_duration_s(record: RunRecord) -> float | None:
    samples = record.log.samples.values() if record.log else ()
    flights = [flight for flight in map(flight_ns, samples) if flight is not None]
    if not flights:
        return None
    return (max(end for _, end in flights) - min(start for start, _ in flights)) / NS_PER_S


def _start_up_s(mission: Sequence[MissionSample]) -> float | None:
    aloft = (sample.wall_time_s for sample in mission if sample.mission_time_s > 0.0)
    return next(aloft, None)


def _real_time_factor(mission: Sequence[MissionSample]) -> float | None:
    flying = [sample for sample in mission if sample.phase is Phase.FLYING]
    if len(flying) < 2:
        return None
    wall_s = flying[-1].wall_time_s - flying[0].wall_time_s
    simulated_s = flying[-1].mission_time_s - flying[0].mission_time_s
    return simulated_s / wall_s if wall_s > 0.0 else None


def _wall_time_s(info: Mapping[str, object], mission: Sequence[MissionSample]) -> float | None:
    """Return the time from the command to the report; a remade report has the same value."""
    if mission:
        return mission[-1].wall_time_s
    wall_time_s = info.get('wall_time_s')
    return float(wall_time_s) if isinstance(wall_time_s, (int, float)) else None


def _restarts(info: Mapping[str, object]) -> dict[str, int]:
    counts = info.get('restarts')
    return {str(k): int(v) for k, v in counts.items()} if isinstance(counts, Mapping) else {}


def _lost(info: Mapping[str, object]) -> dict[str, str]:
    lost = info.get('lost_vehicles')
    return {str(k): str(v) for k, v in lost.items()} if isinstance(lost, Mapping) else {}


def _over_ground(top: HighestReading | None, scenario: Scenario | None) -> HighestReading | None:
    """Return `top` with its height above the ground where that is level and known."""
    if top is None or scenario is None or scenario.survey.terrain_file:
        return top
    enu = LocalFrame(scenario.origin_position()).to_enu(
        top.latitude_deg, top.longitude_deg, top.altitude_m
    )
    height_m = float(enu[0, 2])
    return dataclasses.replace(top, height_agl_m=height_m) if math.isfinite(height_m) else top


def _versions(info: Mapping[str, object]) -> dict[str, str]:
    """Return the versions of the software of the run."""
    found = {}
    if info.get('git_revision'):
        changes = ' with changes' if info.get('git_dirty') else ''
        found['revision'] = f'{info["git_revision"]}{changes}'
    for key, name in (('ros_distro', 'ROS 2'), ('platform', 'platform')):
        if info.get(key):
            found[name] = str(info[key])
    listed = info.get('versions')
    if isinstance(listed, Mapping):
        found.update((str(name), str(text)) for name, text in listed.items())
    return found
