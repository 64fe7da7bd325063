# SPDX-License-Identifier: Apache-2.0
"""Limits of plausible numbers in a message, which a right checksum does not prove.

Only messages named here pass. Each number that is used later must be within its limits, or the
whole message is dropped. A comparison with NaN is false, so what is not finite never passes.
"""

import math
from collections.abc import Mapping

from rocsafe_mavlink.wire.dialect import Message

Limits = tuple[float, float]
LATITUDE: Limits = (-90e7, 90e7)
LONGITUDE: Limits = (-180e7, 180e7)
ALTITUDE_M: Limits = (-500.0, 20_000.0)
ALTITUDE_MM: Limits = (-500e3, 20_000e3)
ALTITUDE_AIRCRAFT_MM: Limits = (-1e6, 30_000e3)
WIND_MPS: Limits = (-100.0, 100.0)
HEIGHT_M: Limits = (-20_500.0, 20_500.0)
HEIGHT_MM: Limits = (-20_500e3, 20_500e3)
ANGLE_RAD: Limits = (-2.0 * math.pi, 2.0 * math.pi)
TURN_RADPS: Limits = (-100.0, 100.0)
SPEED_CMPS: Limits = (-30_000.0, 30_000.0)
DEGREES: Limits = (-360.0, 360.0)
SEQUENCE: Limits = (0, 65_534)
PERCENT: Limits = (-1, 100)
FINITE: Limits = (-3.5e38, 3.5e38)

_PLACE_MM = {'lat': LATITUDE, 'lon': LONGITUDE, 'alt': ALTITUDE_MM}
LIMITS: Mapping[str, Mapping[str, Limits]] = {
    'ADSB_VEHICLE': {
        'lat': LATITUDE,
        'lon': LONGITUDE,
        'altitude': ALTITUDE_AIRCRAFT_MM,
        'heading': (0, 36_000),
    },
    'TUNNEL': {},
    'ATTITUDE': {
        **dict.fromkeys(('roll', 'pitch', 'yaw'), ANGLE_RAD),
        **dict.fromkeys(('rollspeed', 'pitchspeed', 'yawspeed'), TURN_RADPS),
    },
    'AUTOPILOT_VERSION': {},
    'BATTERY_STATUS': {'battery_remaining': PERCENT},
    'CAMERA_FEEDBACK': {
        'lat': LATITUDE,
        'lng': LONGITUDE,
        'alt_msl': ALTITUDE_M,
        'alt_rel': HEIGHT_M,
        **dict.fromkeys(('roll', 'pitch', 'yaw'), DEGREES),
    },
    'CAMERA_IMAGE_CAPTURED': {'lat': LATITUDE, 'lon': LONGITUDE, 'alt': ALTITUDE_MM},
    'CAMERA_TRIGGER': {},
    'COMMAND_ACK': {},
    'EKF_STATUS_REPORT': {},
    'ESTIMATOR_STATUS': {},
    'EVENT': {},
    'EXTENDED_SYS_STATE': {},
    'FENCE_STATUS': {},
    'GLOBAL_POSITION_INT': {
        **_PLACE_MM,
        'relative_alt': HEIGHT_MM,
        **dict.fromkeys(('vx', 'vy', 'vz'), SPEED_CMPS),
    },
    'GPS_RAW_INT': {**_PLACE_MM, 'alt_ellipsoid': ALTITUDE_MM},
    'HEARTBEAT': {},
    'HOME_POSITION': {'latitude': LATITUDE, 'longitude': LONGITUDE, 'altitude': ALTITUDE_MM},
    'MISSION_ACK': {},
    'MISSION_COUNT': {},
    'MISSION_CURRENT': {'seq': SEQUENCE},
    # Items are compared with what was sent; their unused parameters may be NaN.
    'MISSION_ITEM_INT': {'seq': SEQUENCE, 'x': (-(2**31), 2**31 - 1), 'z': FINITE},
    'MISSION_ITEM_REACHED': {'seq': SEQUENCE},
    'MISSION_REQUEST': {'seq': SEQUENCE},
    'MISSION_REQUEST_INT': {'seq': SEQUENCE},
    'PARAM_VALUE': {},
    'POSITION_TARGET_GLOBAL_INT': {
        'lat_int': LATITUDE,
        'lon_int': LONGITUDE,
        'alt': ALTITUDE_M,
    },
    'RADIO_STATUS': {},
    'STATUSTEXT': {'severity': (0, 7)},
    'SYS_STATUS': {'battery_remaining': PERCENT},
    'WIND': {'speed': (0.0, 100.0)},
    'WIND_COV': {'wind_x': WIND_MPS, 'wind_y': WIND_MPS},
}


def is_read(name: str) -> bool:
    """Whether any part of the bridge uses messages called `name`."""
    return name in LIMITS


def fault_of(message: Message) -> str:
    """Return the name of a field whose value cannot be true; empty if there is none."""
    for name, (low, high) in LIMITS[message.name].items():
        if not low <= message.fields[name] <= high:
            return name
    return ''
