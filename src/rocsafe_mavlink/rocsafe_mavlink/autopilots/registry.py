# SPDX-License-Identifier: Apache-2.0
"""The known autopilots; the heartbeat selects one, never a parameter."""

from rocsafe_mavlink.autopilots.ardupilot import COPTER, ROVER
from rocsafe_mavlink.autopilots.autopilot import Autopilot
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.knowledge.telemetry import GROUND_ROVER

AUTOPILOTS = {kind.number: kind for kind in (COPTER, MULTICOPTER)}
# MAV_TYPE: quadrotor, coaxial, helicopter, hexa, octo, tri, dodeca and decarotor.
ROTORCRAFT = frozenset({2, 3, 4, 13, 14, 15, 29, 35})


def autopilot_of(number: int, vehicle_type: int) -> Autopilot:
    """Return the tables for a heartbeat's MAV_AUTOPILOT and MAV_TYPE.

    Raises
    ------
    ValueError
        If the autopilot is not known, or the vehicle is neither a multicopter nor a rover that
        it drives.
    """
    if number not in AUTOPILOTS:
        known = ', '.join(f'{kind.number} ({kind.name})' for kind in AUTOPILOTS.values())
        raise ValueError(f'autopilot = {number} is not known; known are {known}')
    if number == ROVER.number and vehicle_type == GROUND_ROVER:
        return ROVER
    if vehicle_type not in ROTORCRAFT:
        raise ValueError(
            f'vehicle type = {vehicle_type} is no multicopter, nor an ArduPilot Rover'
        )
    return AUTOPILOTS[number]
