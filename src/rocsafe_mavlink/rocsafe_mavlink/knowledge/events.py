# SPDX-License-Identifier: Apache-2.0
"""Events: what changed between two states of a vehicle."""

from dataclasses import dataclass
from enum import Enum

from rocsafe_mavlink.knowledge.telemetry import SystemStatus, VehicleTelemetry


class EventKind(Enum):
    """Kinds of events."""

    FOUND = 'found'
    REBOOTED = 'started again'
    MODE = 'mode'
    ARMED = 'armed'
    DISARMED = 'disarmed'
    STATUS = 'status'
    LANDED = 'landed state'
    HOME = 'home'
    REACHED = 'item reached'
    FENCE = 'fence'
    TEXT = 'text'


@dataclass(frozen=True, slots=True)
class Event:
    """One event, with a word for people."""

    kind: EventKind
    text: str = ''
    severity: int = 6


def events_between(before: VehicleTelemetry, after: VehicleTelemetry) -> list[Event]:
    """Return the events from one state to the next; texts come separately."""
    events = []
    if before.autopilot is None and after.autopilot is not None:
        events.append(Event(EventKind.FOUND, f'{after.system}/{after.component}'))
    if before.is_armed != after.is_armed:
        events.append(Event(EventKind.ARMED if after.is_armed else EventKind.DISARMED))
    for kind, old, new in _compared(before, after):
        if old != new:
            events.append(Event(kind, str(new)))
    if after.mission.reached > before.mission.reached:
        events.append(Event(EventKind.REACHED, str(after.mission.reached)))
    if after.home is not None and before.home != after.home:
        events.append(Event(EventKind.HOME))
    return events


def _compared(
    before: VehicleTelemetry, after: VehicleTelemetry
) -> list[tuple[EventKind, object, object]]:
    return [
        (EventKind.MODE, before.custom_mode, after.custom_mode),
        (EventKind.STATUS, _status(before), _status(after)),
        (EventKind.LANDED, before.landed.name, after.landed.name),
        (EventKind.FENCE, before.is_fence_breached, after.is_fence_breached),
    ]


def _status(vehicle: VehicleTelemetry) -> str:
    try:
        return SystemStatus(vehicle.status).name
    except ValueError:
        return str(vehicle.status)
