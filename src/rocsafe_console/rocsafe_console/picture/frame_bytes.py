# SPDX-License-Identifier: Apache-2.0
"""Positions of all vehicles as bytes, as static/link.js reads them.

A frame is a head and 24 bytes a vehicle, little endian. The head: letter ``P``, version, number of
vehicles (u16), sequence number (u32), time of the wall (f64, seconds since 1970), time of the
mission (f64, seconds since 1970, NaN if unknown). A vehicle: number (u16), state (u8), flags (u8),
latitude and longitude (i32, 1e-7 degree), height above home or the ellipsoid (i16, 0.1 m), speed
(u16, 0.01 m/s), battery (u8, per cent), visited (u8, per cent), age (u16, 0.1 s), dose rate (f32,
uSv/h). What is unknown has the largest value of its field, or NaN.
"""

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

VERSION = 1
HEAD = struct.Struct('<2sHIdd')
VEHICLE = struct.Struct('<HBBiihHBBHf')
UNKNOWN_U8, UNKNOWN_U16, UNKNOWN_I16, UNKNOWN_I32 = 0xFF, 0xFFFF, 0x7FFF, 0x7FFFFFFF
# Flags; the last two: its place and its dose are old, though it may be heard.
SIMULATED, TAKEN, OLD_PLACE, OLD_DOSE = 1, 2, 4, 8
_MOST_AGE_DS = UNKNOWN_U16 - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleFrame:
    """What a frame tells of a vehicle; units as in the module, unknown numbers are NaN."""

    number: int
    state: int
    flags: int = 0
    latitude_deg: float = math.nan
    longitude_deg: float = math.nan
    height_m: float = math.nan
    speed_mps: float = math.nan
    battery_fraction: float = math.nan
    visited_fraction: float = math.nan
    age_s: float = math.inf
    dose_rate_usvh: float = math.nan

    def __post_init__(self) -> None:
        if not 0 <= self.number < UNKNOWN_U16 or not 0 <= self.state <= UNKNOWN_U8:
            raise ValueError(
                f'number = {self.number}, state = {self.state}: must be within 0 and '
                f'{UNKNOWN_U16 - 1}, and 0 and {UNKNOWN_U8}'
            )

    def pack(self) -> bytes:
        """Return its bytes."""
        return VEHICLE.pack(
            self.number,
            self.state,
            self.flags,
            _scaled(self.latitude_deg, 1e7, -UNKNOWN_I32, UNKNOWN_I32),
            _scaled(self.longitude_deg, 1e7, -UNKNOWN_I32, UNKNOWN_I32),
            _scaled(self.height_m, 10.0, -UNKNOWN_I16, UNKNOWN_I16),
            _scaled(self.speed_mps, 100.0, 0, UNKNOWN_U16),
            _scaled(self.battery_fraction, 100.0, 0, UNKNOWN_U8),
            _scaled(self.visited_fraction, 100.0, 0, UNKNOWN_U8),
            min(_scaled(self.age_s, 10.0, 0, UNKNOWN_U16), _MOST_AGE_DS)
            if math.isfinite(self.age_s)
            else UNKNOWN_U16,
            self.dose_rate_usvh,
        )


def frame_of(packed: Sequence[bytes], sequence: int, wall_s: float, mission_s: float) -> bytes:
    """Return the frame of vehicles that are packed.

    Parameters
    ----------
    sequence
        Number of the frame; rises by one.
    wall_s, mission_s
        Seconds since 1970 by the clock on the wall and by that of the mission.
    """
    letter = b'P' + bytes([VERSION])
    head = HEAD.pack(letter, len(packed), sequence & 0xFFFFFFFF, wall_s, mission_s)
    return head + b''.join(packed)


def _scaled(value: float, per_unit: float, least: int, unknown: int) -> int:
    """Return `value` in steps of its field, within its limits; the largest is for unknown."""
    if not math.isfinite(value):
        return unknown
    return round(max(float(least), min(value * per_unit, unknown - 1.0)))
