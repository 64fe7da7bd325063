# SPDX-License-Identifier: Apache-2.0
"""The request for a drive of the ground vehicle, and what it has done so far."""

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from rocsafe_geo.evidence.place_marks import PlaceMark
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_interfaces.action import DriveRoute, PlanGroundRoute
from rocsafe_interfaces.msg import EvidencePoint, GeoPoint, GroundRoute
from rocsafe_orchestrator.mission.drive_watch import DriveWatch, WatchedStop
from rocsafe_ros.conversions import point_of_position, position_of_point
from rocsafe_scenario.blocks.ground_vehicle import GroundVehicleBlock
from rocsafe_scenario.scenario import Scenario

SOURCE, RELEASE = 'source', 'release'
Found = Sequence[tuple[GeoPosition, float]]
# A background, and the square of the least distance to a source.
LEAST_RATE_USVH, LEAST_M2 = 0.1, 1.0
# Budgets that are used up: the router then says what the least ones would be.
LEAST_BUDGET_USV, LEAST_ENDURANCE_S = 1e-6, 1.0
# What is found nearer than this to what was found before is the same: one photograph shows both.
SAME_M = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveSoFar:
    """What earlier drives of a mission have done.

    Attributes
    ----------
    evidence
        Ids of the evidence taken.
    dose_usv, duration_s
        Taken by the vehicle, and how long it drove.
    position
        Where it stands; None: at home.
    blocked
        Where something stood in its way.
    found
        Sources and releases that were asked for.
    objects
        Things that labels proposed at the first request; None: not asked yet.
    """

    evidence: tuple[str, ...] = ()
    dose_usv: float = 0.0
    duration_s: float = 0.0
    position: GeoPoint | None = None
    blocked: tuple[GeoPoint, ...] = ()
    found: tuple[EvidencePoint, ...] = ()
    objects: tuple[EvidencePoint, ...] | None = None

    def asked(self, evidence: Sequence[EvidencePoint]) -> 'DriveSoFar':
        """Return it after a request for a drive to evidence."""
        known = {one.id for one in self.found}
        new = (one for one in evidence if one.found_in and one.id not in known)
        return replace(self, found=(*self.found, *new))

    def after(self, result: DriveRoute.Result) -> 'DriveSoFar':
        """Return it after another drive."""
        return replace(
            self,
            evidence=(*self.evidence, *result.evidence_taken),
            dose_usv=self.dose_usv + result.dose_usv,
            duration_s=self.duration_s + result.duration_s,
            position=result.position,
            blocked=(*self.blocked, *result.blocked),
        )


def drive_goal(
    scenario: Scenario,
    sources: Found,
    releases: Found,
    so_far: DriveSoFar,
    marks: Sequence[PlaceMark] = (),
    release_unit: str = 'g/s',
) -> PlanGroundRoute.Goal | None:
    """Return the request to the router, None if nothing is left to be taken.

    `sources` are places and dose rates at 1 m, `releases` places and rates in `release_unit`,
    `marks` are those of operators.
    """
    block = scenario.ground_vehicle
    if block is None:
        return None
    evidence = [
        one
        for one in (
            *_named(block, marks),
            *_evidence(block, sources, releases, release_unit, so_far.found),
            *(so_far.objects or ()),
        )
        if one.id not in so_far.evidence
    ]
    to_objects = bool(block.labels_file) and block.to_objects and so_far.objects is None
    if not evidence and not to_objects:
        return None
    home = point_of_position(scenario.ground_position(block.home))
    return PlanGroundRoute.Goal(
        vehicle=block.name,
        start=home if so_far.position is None else so_far.position,
        end=[] if so_far.position is None else [home],
        blocked=list(so_far.blocked),
        evidence=evidence,
        to_objects=to_objects,
        object_dwell_s=block.dwell_s,
        dose_budget_usv=max(block.dose_budget_usv - so_far.dose_usv, LEAST_BUDGET_USV),
        load_budget=block.load_budget or 0.0,
        turn_back_usvh=block.turn_back_usvh,
        turn_back_ppm=block.turn_back_ppm or 0.0,
        endurance_s=max(block.endurance_s - so_far.duration_s, LEAST_ENDURANCE_S),
    )


def _named(block: GroundVehicleBlock, marks: Sequence[PlaceMark]) -> Iterator[EvidencePoint]:
    for one in block.evidence:
        yield EvidencePoint(
            id=one.name, kind=one.kind, position=point_of_position(GeoPosition(*one.position)),
            priority=one.priority, dwell_s=one.dwell_s,
        )  # fmt: skip
    for number, mark in enumerate(marks if block.to_marks else (), 1):
        yield EvidencePoint(
            id=f'operator-{number}', kind='mark', position=point_of_position(mark.position),
            priority=1.0, dwell_s=block.dwell_s, found_in=f'{mark.by}: {mark.text}',
        )  # fmt: skip


def _evidence(
    block: GroundVehicleBlock,
    sources: Found,
    releases: Found,
    release_unit: str,
    known: Sequence[EvidencePoint],
) -> Iterator[EvidencePoint]:
    if block.to_sources:
        yield from _found(SOURCE, 'uSv/h at 1 m', sources, block.dwell_s, known)
    if block.to_releases:
        yield from _found(RELEASE, release_unit, releases, block.dwell_s, known)


def _found(
    kind: str, unit: str, found: Found, dwell_s: float, known: Sequence[EvidencePoint]
) -> Iterator[EvidencePoint]:
    """Yield a point for each of what was found, the stronger the higher its priority.

    Its name is that of the nearest one `known`: their order changes with each assessment.
    """
    strongest = max((rate for _, rate in found), default=1.0)
    own = {one.id: position_of_point(one.position) for one in known if one.kind == kind}
    names = set[str]()
    for place, rate in found:
        away = {name: distance_m(place, before) for name, before in own.items()}
        name = min(away, key=away.__getitem__, default='')
        if not name or away[name] >= SAME_M:
            name = f'{kind}-{len(own.keys() | names) + 1}'
        if name in names:
            continue
        names.add(name)
        yield EvidencePoint(
            id=name, kind=kind, position=point_of_position(place),
            priority=max(0.1, rate / strongest), dwell_s=dwell_s,
            found_in=f'{name.replace("-", " ")}: {rate:.4g} {unit}',
        )  # fmt: skip


def dose_change(route: GroundRoute, planned_on: Found, known: Found) -> float:
    """Return how many times the planned dose a route takes by the sources that are known now.

    By 1 / r^2 over a background, at the stops of the route.
    """
    planned = changed = 0.0
    for stop in route.stops:
        place = position_of_point(stop.position)
        planned += stop.dose_usv
        changed += stop.dose_usv * _rate_usvh(place, known) / _rate_usvh(place, planned_on)
    return changed / planned if planned > 0.0 else 1.0


def _rate_usvh(place: GeoPosition, sources: Found) -> float:
    squares = [max(distance_m(place, source) ** 2, LEAST_M2) for source, _ in sources]
    rates = [rate / square for (_, rate), square in zip(sources, squares, strict=True)]
    return LEAST_RATE_USVH + sum(rates)


def task_digest(scenario: Scenario) -> str:
    """Return a hash of what the ground vehicle of a scenario is to do, 8 hexadecimal digits."""
    block = scenario.ground_vehicle
    text = block.model_dump_json() if block else ''
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def drive_watch(route: GroundRoute, taken_usv: float = 0.0) -> DriveWatch:
    """Return the watch over the dose of a route, of which some was taken before."""
    stops = [
        WatchedStop(
            place=position_of_point(stop.position),
            duration_s=stop.duration_s,
            dose_usv=stop.dose_usv,
        )
        for stop in route.stops
    ]
    ratio = route.dose_upper_usv / route.dose_usv if route.dose_usv > 0.0 else 0.0
    return DriveWatch(stops, route.dose_budget_usv, route.turn_back_usvh, ratio, taken_usv)


def drive_text(route: GroundRoute) -> str:
    """Return a planned drive in words."""
    evidence = ', '.join(stop.evidence for stop in route.stops if stop.evidence)
    left = f'; left out: {"; ".join(route.left_out)}' if route.left_out else ''
    return (
        f'{route.vehicle} drives to {evidence}: {route.duration_s:.0f} s, {route.dose_usv:.4g} '
        f'uSv, in 95 of 100 cases below {route.dose_upper_usv:.4g}{left}'
    )
