# SPDX-License-Identifier: Apache-2.0
"""The picture: everything that the page shows of a running mission. Time is an argument.

Times `now_s` are of the wall, seconds since 1970; stamps are of the mission's clock.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from rocsafe_console.picture.alarms import ERROR, WARN, Alarm, Alarms
from rocsafe_console.picture.coordinates import forms_of, is_on_earth
from rocsafe_console.picture.frame_bytes import VehicleFrame
from rocsafe_console.picture.freshness import MissionClock
from rocsafe_console.picture.gas import GasNow, GasReadings
from rocsafe_console.picture.map_image import DOSE, PLUME
from rocsafe_console.picture.sections import Sections
from rocsafe_console.picture.time_left import RouteLeft, routes_left, survey_left_s
from rocsafe_console.picture.vehicle import CRASHED, LOST, Holder, Vehicle, VehicleReport

MOST_VEHICLES = 1000
DECISIONS_KEPT = 500
# 1e12 Sv/h: a fault of a detector.
IMPOSSIBLE_USVH = 1e18
PHASES = (
    'starting', 'planning', 'flying', 'collecting', 'mapping', 'reporting', 'complete', 'failed',
    'cancelled', 'driving',
)  # fmt: skip
_FAILED = PHASES.index('failed')


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionNow:
    """The state of the mission; the names are those of MissionState."""

    mission_id: str
    phase: int
    stamp_s: float
    text: str = ''
    images_stored: int = 0
    images_expected: int = 0
    mission_time_s: float = math.nan
    wall_time_s: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A dose rate of a vehicle, microsievert per hour."""

    vehicle: str
    stamp_s: float
    dose_rate_usvh: float
    std_usvh: float
    latitude_deg: float
    longitude_deg: float
    detector: str
    is_saturated: bool = False


class Picture:
    """The present state of one mission, as it was heard.

    Parameters
    ----------
    first_revision
        Revisions of vehicles and numbers of alarms begin here: an order that names one of an
        earlier process is refused.
    sections
        Emptied ones of the picture before.
    """

    def __init__(self, first_revision: int = 0, sections: Sections | None = None) -> None:
        self.sections = Sections() if sections is None else sections
        self.alarms = Alarms(first_revision)
        self.gas = GasReadings()
        self.vehicles: dict[str, Vehicle] = {}
        self.clock = MissionClock()
        self.mission: MissionNow | None = None
        self.mission_heard_s = -math.inf
        self.worst: Reading | None = None
        self.newest: Reading | None = None
        self._newest_heard_s = -math.inf
        self._worst_heard_s = -math.inf
        self._first_revision = first_revision
        self._decisions: list[dict[str, Any]] = []
        self._contacts: dict[str, dict[str, Any]] = {}
        self._routes: dict[str, RouteLeft] = {}
        self.sections.put('scale', DOSE.stops())
        self.sections.put('gas_scale', PLUME.stops())

    def next_one(self) -> 'Picture':
        """Return an empty picture of another mission; numbers of changes and revisions rise on."""
        self.sections.drop(list(self.sections.after(0)))
        revisions = (vehicle.revision + 1 for vehicle in self.vehicles.values())
        first = max(self._first_revision, self.alarms.newest, *revisions)
        return Picture(first, self.sections)

    def on_mission(self, mission: MissionNow, now_s: float) -> None:
        """Take over the state of the mission."""
        failed_now = mission.phase == _FAILED and (
            self.mission is None or self.mission.phase != _FAILED
        )
        self.mission = mission
        self.clock.mark(mission.stamp_s, now_s)
        self.mission_heard_s = self.clock.heard_s(now_s)
        if failed_now:
            self.alarm(now_s, ERROR, '', f'the mission has failed: {mission.text}')
        phase = PHASES[mission.phase] if mission.phase < len(PHASES) else 'unknown'
        self.sections.put(
            'mission', {'id': mission.mission_id, 'phase': phase, 'text': mission.text}
        )

    def on_report(self, report: VehicleReport, now_s: float) -> None:
        """Take over the state of a vehicle, with the alarms that follow from it."""
        vehicle = self._vehicle(report)
        before, vehicle.report = vehicle.report, report
        if math.isfinite(report.speed_mps):
            vehicle.fastest_mps = max(vehicle.fastest_mps, report.speed_mps)
        # Before its first fix a vehicle does not know the time.
        if vehicle.is_aloft and report.stamp_s > 0.0:
            vehicle.drain.note(report.stamp_s, report.battery_fraction)
        if math.isnan(vehicle.latitude_deg):
            place = (report.latitude_deg, report.longitude_deg, report.altitude_m)
            self._place(vehicle, place, report.stamp_s, now_s)
        self._heard(vehicle, report.stamp_s, now_s)
        if (before.state, before.taken_by) != (report.state, report.taken_by):
            vehicle.revision += 1
            self._judge(before, report, now_s)
        self._tell(vehicle)

    def on_fix(
        self, name: str, place: tuple[float, float, float], stamp_s: float, now_s: float
    ) -> None:
        """Take over latitude and longitude in degrees, and altitude in metres."""
        vehicle = self.vehicles.get(name)
        if vehicle is not None:
            self._place(vehicle, place, stamp_s, now_s)
            self._heard(vehicle, stamp_s, now_s)

    def on_reading(self, reading: Reading, now_s: float) -> None:
        """Take over a dose rate; one that is no possible number is none."""
        vehicle = self.vehicles.get(reading.vehicle)
        if vehicle is None or not abs(reading.dose_rate_usvh) < IMPOSSIBLE_USVH:
            return
        vehicle.dose_rate_usvh = reading.dose_rate_usvh
        vehicle.trend.note(reading.stamp_s, reading.dose_rate_usvh)
        heard_s = vehicle.measured_s = self.clock.wall_of(reading.stamp_s, now_s)
        if self.newest is None or reading.stamp_s >= self.newest.stamp_s:
            self.newest, self._newest_heard_s = reading, heard_s
        if self.worst is None or reading.dose_rate_usvh > self.worst.dose_rate_usvh:
            self.worst, self._worst_heard_s = reading, heard_s

    def on_gas(self, reading: GasNow, now_s: float) -> None:
        """Take over a reading of a gas sensor."""
        self.gas.note(reading, self.clock.wall_of(reading.stamp_s, now_s))

    def on_dose(
        self, name: str, dose_usv: float, stamp_s: float, now_s: float, *, is_lower_limit: bool
    ) -> None:
        """Take over the dose that a vehicle has taken, microsievert."""
        vehicle = self.vehicles.get(name)
        if vehicle is not None:
            vehicle.dosed_s = self.clock.wall_of(stamp_s, now_s)
            vehicle.dose_usv, vehicle.dose_is_lower_limit = dose_usv, is_lower_limit

    def on_holder(self, name: str, holder: Holder, now_s: float) -> None:
        """Take over who leads a vehicle."""
        vehicle = self._vehicle(VehicleReport(name=name, state=0, stamp_s=-math.inf))
        before, vehicle.holder = vehicle.holder, holder
        if (before.epoch, before.lease) != (holder.epoch, holder.lease):
            vehicle.revision += 1
            if before.lease and 'taken over' in holder.text:
                self.alarm(now_s, WARN, name, holder.text)
        self._tell(vehicle)

    def on_home(self, name: str, home: tuple[float, float, float]) -> None:
        """Take over where a vehicle returns to: latitude, longitude in degrees, altitude in m."""
        vehicle = self.vehicles.get(name)
        if vehicle is not None and is_on_earth(*home[:2]):
            vehicle.home = home
            self._tell(vehicle)

    def on_plan(self, plan: Mapping[str, Any]) -> None:
        """Take over the plan that is flown, as `conversions.plan_of` gives it."""
        self._routes = routes_left(plan)
        self.sections.put('plan', plan)

    def on_agent(self, name: str, heard: Sequence[str], stamp_s: float, now_s: float) -> None:
        """Take over which vehicles the agent of a vehicle hears."""
        self._contacts[name] = {
            'hears': sorted(set(heard) - {name}),
            'heard_s': self.clock.wall_of(stamp_s, now_s),
        }

    def on_decision(self, decision: Mapping[str, Any], now_s: float) -> None:
        """Add a decision; one of at least ``warning`` is an alarm."""
        self._add_decision(decision)
        if decision['severity'] in (WARN, ERROR):
            vehicles = decision['vehicles']
            name = vehicles[0] if len(vehicles) == 1 else ''
            text = ': '.join(filter(None, (decision['text'], decision['reason'])))
            self.alarm(now_s, decision['severity'], name, text)

    def on_order(self, by: str, verb: str, outcomes: Mapping[str, str]) -> None:
        """Add what a person has ordered to what was decided: the outcome of each vehicle."""
        seconds = self.mission.wall_time_s if self.mission else math.nan
        order = {'by': by, 'wall_time_s': seconds, 'verb': verb, 'outcomes': dict(outcomes)}
        self._add_decision({**order, 'severity': '', 'text': '', 'reason': ''})

    def alarm(self, now_s: float, severity: str, vehicle: str, text: str) -> Alarm | None:
        """Raise an alarm, unless nobody has seen the same one yet."""
        alarm = self.alarms.raise_one(now_s, severity, vehicle, text)
        if alarm is not None:
            self.sections.put('alarms', self.alarms.to_plain())
        return alarm

    def acknowledge(self, number: int, who: str, now_s: float) -> Alarm:
        """Note that somebody has seen an alarm; raises `ValueError` if there is none."""
        alarm = self.alarms.acknowledge(number, who, now_s)
        self.sections.put('alarms', self.alarms.to_plain())
        return alarm

    def frames(self, now_s: float) -> list[VehicleFrame]:
        """Return the frames of all vehicles."""
        return [vehicle.frame(now_s) for vehicle in self.vehicles.values()]

    def tracks(self) -> dict[str, list[tuple[float, float, float]]]:
        """Return the flown track of each vehicle."""
        return {name: vehicle.track.points for name, vehicle in self.vehicles.items()}

    def tracks_text(self) -> str:
        """Return the flown tracks as a JSON object, each point of which is encoded once."""
        texts = (f'{json.dumps(name)}:{one.track.text}' for name, one in self.vehicles.items())
        return f'{{{",".join(texts)}}}'

    def refresh(self) -> None:
        """Renew the sections that change by the second."""
        mission = self.mission
        flown = [one.report for one in self.vehicles.values() if not one.report.is_ground]
        if mission is not None:
            self.sections.put(
                'progress',
                {
                    'images_stored': mission.images_stored,
                    'images_expected': mission.images_expected,
                    'visited': sum(one.viewpoints_visited for one in flown),
                    'viewpoints': sum(one.viewpoint_count for one in flown),
                    'mission_time_s': mission.mission_time_s,
                    'wall_time_s': mission.wall_time_s,
                    'left_s': survey_left_s(self._routes, self.vehicles.values()),
                },
            )
        self.sections.put('mission_heard_s', self.mission_heard_s)
        worst, newest = self.worst, self.newest
        self.sections.put(
            'dose',
            {
                'worst': worst
                and {
                    **asdict(worst),
                    'heard_s': self._worst_heard_s,
                    'forms': forms_of(worst.latitude_deg, worst.longitude_deg),
                },
                'newest': newest and {**asdict(newest), 'heard_s': self._newest_heard_s},
                'trend': self.vehicles[newest.vehicle].trend.word if newest else '',
            },
        )
        self.sections.put('gas', self.gas.to_plain())
        self.sections.put('contacts', self._contacts)
        slow = {name: vehicle.slow_facts() for name, vehicle in self.vehicles.items()}
        self.sections.put('vehicle_facts', slow)

    def _add_decision(self, decision: Mapping[str, Any]) -> None:
        self._decisions = [*self._decisions, dict(decision)][-DECISIONS_KEPT:]
        self.sections.put('decisions', self._decisions)

    def _vehicle(self, report: VehicleReport) -> Vehicle:
        if report.name not in self.vehicles:
            if len(self.vehicles) >= MOST_VEHICLES:
                raise ValueError(f'{report.name}: more than {MOST_VEHICLES} vehicles')
            self.vehicles[report.name] = Vehicle(
                number=len(self.vehicles),
                name=report.name,
                revision=self._first_revision,
                report=report,
            )
        return self.vehicles[report.name]

    def _heard(self, vehicle: Vehicle, stamp_s: float, now_s: float) -> None:
        vehicle.heard_s = max(vehicle.heard_s, self.clock.wall_of(stamp_s, now_s))

    def _place(
        self, vehicle: Vehicle, place: tuple[float, float, float], stamp_s: float, now_s: float
    ) -> None:
        latitude_deg, longitude_deg, altitude_m = place
        if not is_on_earth(latitude_deg, longitude_deg):
            return
        vehicle.latitude_deg, vehicle.longitude_deg = latitude_deg, longitude_deg
        vehicle.altitude_m = altitude_m
        vehicle.placed_s = self.clock.wall_of(stamp_s, now_s)
        vehicle.track.note(latitude_deg, longitude_deg, vehicle.dose_rate_now(now_s))

    def _judge(self, before: VehicleReport, report: VehicleReport, now_s: float) -> None:
        """Raise the alarms of a change of state."""
        name = report.name
        if report.state in (LOST, CRASHED) and before.state != report.state:
            words = f'{name} is {report.state_name}'
            self.alarm(now_s, ERROR, name, f'{words}: {report.text}' if report.text else words)
        if report.taken_by and not before.taken_by:
            self.alarm(now_s, WARN, name, f'{name} is taken by its {report.taken_by}')

    def _tell(self, vehicle: Vehicle) -> None:
        self.sections.put(f'vehicle/{vehicle.name}', vehicle.to_plain())
