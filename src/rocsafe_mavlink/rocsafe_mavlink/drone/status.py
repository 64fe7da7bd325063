# SPDX-License-Identifier: Apache-2.0
"""Status of a real vehicle at one moment, as it is published."""

import math
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.autopilots.autopilot import Autopilot, FlightState, Verb
from rocsafe_mavlink.checks.preflight import LEVEL_ALLOWANCE
from rocsafe_mavlink.drone.advice import Advice
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.flight.flight_journal import JournalEntry
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.knowledge.fix import fix_fault
from rocsafe_mavlink.knowledge.prediction import Prediction, predict
from rocsafe_mavlink.knowledge.telemetry import Contact, MissionPhase, Motion, VehicleTelemetry
from rocsafe_mavlink.plan.flight_limits import FlightLimits

_SILENT = (Contact.STALE, Contact.LOST)


class FixQuality(IntEnum):
    """Quality of a position, as NavSatStatus counts."""

    NONE = -1
    FIX = 0
    AUGMENTED = 1
    GROUND_BASED = 2


_QUALITIES = {4: FixQuality.AUGMENTED, 5: FixQuality.GROUND_BASED, 6: FixQuality.GROUND_BASED}


@dataclass(frozen=True, slots=True, kw_only=True)
class RemainingRoute:
    """Rest of a route: `visited` of `count` stops are done."""

    visited: int = 0
    count: int = 0
    distance_m: float = 0.0
    time_s: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusInputs:
    """Inputs of a status; `frame` is that of the mission, `advice` the alarms for the operator.

    `journal_fault` says why the journal of the flight is not on disk; empty: it is.
    """

    session: VehicleSession
    entry: JournalEntry | None
    frame: LocalFrame
    distance_m: float
    journal_fault: str = ''
    advice: tuple[Advice, ...] = ()

    @property
    def vehicle(self) -> VehicleTelemetry:
        """What the vehicle said of itself."""
        return self.session.telemetry


@dataclass(frozen=True, slots=True, kw_only=True)
class DroneStatus:
    """One vehicle at one moment.

    Attributes
    ----------
    contact
        How recent this is.
    state
        What it does.
    mode
        Mode of the autopilot, by the autopilot's own name.
    is_armed
        Whether its motors may run.
    motion
        Position and velocity; None if it has not told them.
    position_enu
        Position in the frame of the mission, metres; the height is above home, NaN if not known.
    horizontal_std_m, vertical_std_m
        Standard deviations of its position; NaN if not known.
    plan_id, viewpoint_count, visited
        Its plan and progress.
    charge, voltage_v, current_a
        Its battery; NaN if not known.
    distance_m
        Distance flown.
    text
        Explanation for people.
    advice
        Order that is offered; empty: none.
    prediction
        Expected position while it is silent.
    ending
        How its present or last flight ends, if not as planned; None: as planned, or none.
    taken_by
        Who has it in the air, see `Custody.holder`; empty: nobody but this bridge.
    """

    contact: Contact
    state: FlightState
    mode: str
    is_armed: bool
    motion: Motion | None
    position_enu: Enu
    horizontal_std_m: float
    vertical_std_m: float
    plan_id: str
    viewpoint_count: int
    visited: int
    charge: float
    voltage_v: float
    current_a: float
    distance_m: float
    text: str
    advice: str
    prediction: Prediction | None
    ending: FlightOutcome | None
    taken_by: str


def status_of(inputs: StatusInputs, now_s: float) -> DroneStatus:
    """Return the status of a vehicle at `now_s`, steady seconds."""
    vehicle, entry, motion = inputs.vehicle, inputs.entry, inputs.vehicle.motion
    autopilot = inputs.session.known_autopilot()
    state = FlightState.UNKNOWN if autopilot is None else autopilot.state_of(vehicle, now_s)
    fault = fix_fault(vehicle, now_s)
    contact, plan = vehicle.contact(now_s), None if entry is None else entry.assignment
    prediction = _prediction(inputs, autopilot, now_s) if contact in _SILENT else None
    return DroneStatus(
        contact=contact,
        state=state,
        mode='' if autopilot is None else autopilot.mode_name(vehicle.custom_mode),
        is_armed=vehicle.is_armed,
        motion=motion,
        position_enu=(0.0, 0.0, 0.0) if motion is None else enu_of(inputs.frame, motion),
        horizontal_std_m=vehicle.gps.horizontal_std_m,
        vertical_std_m=vehicle.gps.vertical_std_m,
        plan_id='' if plan is None else plan.plan_id,
        viewpoint_count=0 if plan is None else len(plan.viewpoint_ids),
        visited=_visited(inputs),
        charge=vehicle.battery.fraction,
        voltage_v=vehicle.battery.voltage_v,
        current_a=vehicle.battery.current_a,
        distance_m=inputs.distance_m,
        text=_text(inputs, fault, prediction, now_s),
        advice=inputs.advice[0].order if inputs.advice else '',
        prediction=prediction,
        ending=_ending(inputs),
        taken_by=_taken_by(inputs, contact),
    )


def _ending(inputs: StatusInputs) -> FlightOutcome | None:
    flight, entry = inputs.session.flight, inputs.entry
    if flight is not None and not flight.is_over:
        return flight.cause
    outcome = None if entry is None else entry.outcome
    return None if outcome is FlightOutcome.COMPLETED else outcome


def _taken_by(inputs: StatusInputs, contact: Contact) -> str:
    """Return who has the vehicle; autopilots switch to another mode after the last viewpoint."""
    session, flight = inputs.session, inputs.session.flight
    autopilot = session.known_autopilot()
    if autopilot is None or contact is not Contact.FRESH or inputs.vehicle.is_on_ground:
        return ''
    if flight is None or flight.is_beginning or flight.is_over:
        return ''
    is_done = flight.cause is None and flight.visited == len(flight.mission.waypoint_items)
    return '' if is_done else session.custody.holder(inputs.vehicle, autopilot)


def remaining_route(inputs: StatusInputs, limits: FlightLimits) -> RemainingRoute:
    """Return the rest of the route of a vehicle, to touch-down."""
    if inputs.entry is None or inputs.vehicle.home is None:
        return RemainingRoute()
    plan, visited = inputs.entry.assignment.plan, _visited(inputs)
    home = GeoPosition(inputs.vehicle.home.latitude_deg, inputs.vehicle.home.longitude_deg)
    stops = plan.stops[visited:]
    here = home if inputs.vehicle.motion is None else inputs.vehicle.motion.position
    way = [here, *(stop.position for stop in stops), home]
    distance = sum(distance_m(a, b) for a, b in pairwise(way))
    height_m = plan.waypoints[-1].height_m
    time_s = LEVEL_ALLOWANCE * distance / plan.speed_mps + height_m / limits.descent_mps
    time_s += sum(stop.hold_s for stop in stops)
    return RemainingRoute(
        visited=visited, count=len(plan.stops), distance_m=distance, time_s=time_s
    )


def fix_quality(vehicle: VehicleTelemetry, now_s: float) -> FixQuality:
    """Return the quality of the position of a vehicle at `now_s`, steady seconds."""
    if fix_fault(vehicle, now_s):
        return FixQuality.NONE
    return _QUALITIES.get(vehicle.gps.fix_type, FixQuality.FIX)


def enu_of(frame: LocalFrame, motion: Motion) -> Enu:
    """Return the position of a vehicle in the frame of the mission; its height is above home."""
    east, north, _ = frame.enu_of(_on_ground(frame, motion.position)).tolist()
    return east, north, motion.height_above_home_m


def _visited(inputs: StatusInputs) -> int:
    noted = 0 if inputs.entry is None else inputs.entry.visited
    flight = inputs.session.flight
    return noted if flight is None else max(noted, flight.visited)


def _on_ground(frame: LocalFrame, place: GeoPosition) -> GeoPosition:
    return GeoPosition(place.latitude_deg, place.longitude_deg, frame.origin.altitude_m)


def _prediction(
    inputs: StatusInputs, autopilot: Autopilot | None, now_s: float
) -> Prediction | None:
    """Return the expected position of a silent vehicle, which is assumed to go on as before."""
    vehicle, motion = inputs.vehicle, inputs.vehicle.motion
    if motion is None:
        return None
    is_paused = vehicle.mission.phase is MissionPhase.PAUSED
    is_on_way = autopilot is not None and autopilot.is_in(vehicle, Verb.MISSION) and not is_paused
    if not is_on_way or inputs.entry is None or vehicle.is_on_ground:
        return predict(motion.position, (), 0.0, 0.0)
    plan = inputs.entry.assignment.plan
    way = [stop.position for stop in plan.stops[_visited(inputs) :]]
    if vehicle.home is not None:
        way.append(GeoPosition(vehicle.home.latitude_deg, vehicle.home.longitude_deg))
    return predict(motion.position, way, plan.speed_mps, now_s - motion.heard_s)


def _text(inputs: StatusInputs, fault: str, prediction: Prediction | None, now_s: float) -> str:
    vehicle, flight = inputs.vehicle, inputs.session.flight
    if vehicle.autopilot is None:
        return 'never heard'
    kind, custody = inputs.session.known_autopilot(), inputs.session.custody
    parts = [] if kind is None else [f'mode {kind.mode_name(vehicle.custom_mode)}']
    if custody.takeover and custody.failsafe is None:
        parts.append(custody.takeover)
    parts += [f'{one.reason}: {one.order} is offered' for one in inputs.advice]
    if inputs.session.has_twin(now_s):
        parts.append(f'another station speaks as system {inputs.session.us[0]}, as this one does')
    if inputs.journal_fault:
        parts.append(f'a restart of the bridge would not find its flight: {inputs.journal_fault}')
    if prediction is not None:
        place, silent_s = prediction.position, now_s - vehicle.heartbeat_s
        parts.append(
            f'silent for {silent_s:.0f} s; should be near {place.latitude_deg:.6f}, '
            f'{place.longitude_deg:.6f}, {prediction.passed} waypoints further'
        )
    if flight is not None and (flight.cause or flight.reason):
        cause = flight.cause.value if flight.cause else ''
        parts.append(': '.join(filter(None, (cause, flight.reason))))
    if fault and prediction is None:
        parts.append(f'no fix: {fault}')
    elif math.isnan(vehicle.geoid_separation_m):
        parts.append('altitude not known: nobody told how high the geoid is')
    return '; '.join(parts)
