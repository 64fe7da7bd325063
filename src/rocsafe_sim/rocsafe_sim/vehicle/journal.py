# SPDX-License-Identifier: Apache-2.0
"""File of the record of a vehicle, from which a restarted process continues its flight.

The shortest decimal form of a float reads back as the same float: nothing is rounded.
"""

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rocsafe_geo.motion.state import Enu
from rocsafe_geo.storage.durable import replace_whole
from rocsafe_sim.errors import JournalError
from rocsafe_sim.flight.commands import Command, CommandKind
from rocsafe_sim.flight.route import BatterySwap, FlightRoute, RouteWaypoint
from rocsafe_sim.flight.segment import FlightPose
from rocsafe_sim.vehicle.flight_record import FlightOutcome, FlightRecord, VehicleRecord

FORMAT = 5


def write_journal(path: Path, record: VehicleRecord) -> None:
    """Write `record` as JSON, atomically."""
    text = json.dumps({'format': FORMAT, **asdict(record)}, default=_plain)
    replace_whole(path, text.encode())


def read_journal(path: Path) -> VehicleRecord | None:
    """Return the record written to `path`, None if there is no such file.

    Raises
    ------
    JournalError
        If the file is not such a record.
    """
    try:
        fields = json.loads(path.read_text())
        if fields['format'] != FORMAT:
            raise JournalError(f'{path}: format is {fields["format"]}: must be {FORMAT}')
        return _vehicle(fields)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise JournalError(f'{path}: not a vehicle journal: {error!r}') from error


def _plain(value: object) -> object:
    if isinstance(value, (FlightOutcome, CommandKind)):
        return value.value
    raise TypeError(f'{type(value).__name__} has no place in a journal')


def _vehicle(fields: dict[str, Any]) -> VehicleRecord:
    flight = fields['flight']
    return VehicleRecord(
        home_enu=_enu(fields['home_enu']),
        shots_taken=int(fields['shots_taken']),
        flight=None if flight is None else _flight(flight),
    )


def _flight(fields: dict[str, Any]) -> FlightRecord:
    outcome = fields['outcome']
    return FlightRecord(
        **{
            **fields,
            'route': _route(fields['route']),
            'command': _command(fields['command']),
            'outcome': None if outcome is None else FlightOutcome(outcome),
            'ending': FlightOutcome(fields['ending']),
        }
    )


def _command(fields: dict[str, Any]) -> Command:
    start = fields['start']
    pose = FlightPose(
        position_enu=_enu(start['position_enu']),
        velocity_enu=_enu(start['velocity_enu']),
        yaw_rad=float(start['yaw_rad']),
        acceleration_enu=_enu(start['acceleration_enu']),
    )
    return Command(**{**fields, 'kind': CommandKind(fields['kind']), 'start': pose})


def _route(fields: dict[str, Any]) -> FlightRoute:
    return FlightRoute(
        plan_id=str(fields['plan_id']),
        home_enu=_enu(fields['home_enu']),
        waypoints=tuple(
            RouteWaypoint(
                **{
                    **waypoint,
                    'position_enu': _enu(waypoint['position_enu']),
                    'approach_enu': tuple(map(_enu, waypoint['approach_enu'])),
                }
            )
            for waypoint in fields['waypoints']
        ),
        homeward_enu=tuple(map(_enu, fields['homeward_enu'])),
        exclusions=tuple(
            tuple((float(east), float(north)) for east, north in ring)
            for ring in fields['exclusions']
        ),
        clearance_m=float(fields['clearance_m']),
        delay_s=float(fields['delay_s']),
        swaps=tuple(_swap(swap) for swap in fields['swaps']),
        swap_s=float(fields['swap_s']),
        landing_enu=_place(fields['landing_enu']),
        is_open=bool(fields['is_open']),
        height_m=float(fields['height_m']),
        begins_enu=_place(fields['begins_enu']),
    )


def _swap(fields: dict[str, Any]) -> BatterySwap:
    return BatterySwap(
        after=int(fields['after']), homeward_enu=tuple(map(_enu, fields['homeward_enu']))
    )


def _place(values: list[float] | None) -> Enu | None:
    return None if values is None else _enu(values)


def _enu(values: list[float]) -> Enu:
    east, north, up = values
    if not all(math.isfinite(value) for value in values):
        raise ValueError(f'position {values}: must be finite')
    return (east, north, up)
