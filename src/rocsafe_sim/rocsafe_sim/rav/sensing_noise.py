# SPDX-License-Identifier: Apache-2.0
"""Errors of the sensors of a vehicle, as functions of seed, vehicle, and time or number.

No generator is kept between calls. Errors depend neither on the order of calls nor on the speed of
a run, and a restarted process repeats them.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from zlib import crc32

import numpy as np

from rocsafe_geo.motion.state import Enu

# Interval of the knots between which the error of the receiver varies slowly; a tenth of its
# variance is new in every fix.
KNOT_PERIOD_NS = 20_000_000_000
_WHITE_VARIANCE_SHARE = 0.1
# Largest sway: a vehicle that sways further does not release the shutter.
LARGEST_SWAY_STDS = 3.5

# Interval of the knots between which the sway of a stream varies.
SWAY_PERIOD_NS = 1_000_000_000

_GPS_WANDER, _GPS_WHITE, _SWAY, _ATTITUDE, _SWAY_WANDER = range(5)


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorNoise:
    """Errors of the sensors of one vehicle.

    Attributes
    ----------
    seed
        Seed of the run, 0 or above.
    vehicle
        Name of the vehicle.
    gps_horizontal_std_m, gps_vertical_std_m
        Standard deviation of east and north each, and of altitude, metres.
    tilt_std_rad
        Standard deviation of the sway in roll and in pitch, rad.
    attitude_std_rad
        Standard deviation of the measured attitude about each axis, rad.
    """

    seed: int
    vehicle: str
    gps_horizontal_std_m: float
    gps_vertical_std_m: float
    tilt_std_rad: float
    attitude_std_rad: float

    def gps_error_m(self, time_ns: int) -> Enu:
        """Return the error of the receiver (east, north, up) at a simulated time.

        At every time it is normal with the stated standard deviations. Values at knots are blended
        by cosine and sine, whose squares add up to 1.
        """
        knot, rest_ns = divmod(time_ns, KNOT_PERIOD_NS)
        turn = 0.5 * math.pi * rest_ns / KNOT_PERIOD_NS
        wander_share = math.sqrt(1.0 - _WHITE_VARIANCE_SHARE)
        early, late = wander_share * math.cos(turn), wander_share * math.sin(turn)
        before, after = self._draw(_GPS_WANDER, knot), self._draw(_GPS_WANDER, knot + 1)
        white = self._fresh(_GPS_WHITE, time_ns)
        white_share = math.sqrt(_WHITE_VARIANCE_SHARE)
        east, north, up = (
            early * a + late * b + white_share * c
            for a, b, c in zip(before, after, white, strict=True)
        )
        horizontal = self.gps_horizontal_std_m
        return horizontal * east, horizontal * north, self.gps_vertical_std_m * up

    def sway_rad(self, sequence: int) -> tuple[float, float]:
        """Return true (roll, pitch) at the photograph with this number."""
        roll, pitch, _ = self._fresh(_SWAY, sequence)
        return self._swayed(roll, pitch)

    def sway_at_rad(self, time_ns: int) -> tuple[float, float]:
        """Return true (roll, pitch) at a simulated time, continuous, with the same deviations."""
        knot, rest_ns = divmod(time_ns, SWAY_PERIOD_NS)
        turn = 0.5 * math.pi * rest_ns / SWAY_PERIOD_NS
        before, after = self._draw(_SWAY_WANDER, knot), self._draw(_SWAY_WANDER, knot + 1)
        roll, pitch = (
            math.cos(turn) * a + math.sin(turn) * b
            for a, b in zip(before[:2], after[:2], strict=True)
        )
        return self._swayed(roll, pitch)

    def _swayed(self, roll: float, pitch: float) -> tuple[float, float]:
        # Both limits together keep the tilt, their hypotenuse, within LARGEST_SWAY_STDS.
        limit = LARGEST_SWAY_STDS / math.sqrt(2.0)
        roll, pitch = (min(max(value, -limit), limit) for value in (roll, pitch))
        return self.tilt_std_rad * roll, self.tilt_std_rad * pitch

    def attitude_error_rad(self, sequence: int) -> tuple[float, float, float]:
        """Return the error of measured (roll, pitch, yaw) at the photograph with this number."""
        roll, pitch, yaw = self._fresh(_ATTITUDE, sequence)
        std = self.attitude_std_rad
        return std * roll, std * pitch, std * yaw

    def picture_rng(self, camera: str, time_ns: int) -> np.random.Generator:
        """Return the generator of the noise of an image."""
        key = [self.seed, crc32(self.vehicle.encode()), crc32(camera.encode()), time_ns]
        return np.random.default_rng(key)

    def _draw(self, stream: int, index: int) -> tuple[float, ...]:
        return _kept_normals(self.seed, self.vehicle, stream, index)

    def _fresh(self, stream: int, index: int) -> tuple[float, ...]:
        return _normals(self.seed, self.vehicle, stream, index)


def _normals(seed: int, vehicle: str, stream: int, index: int) -> tuple[float, ...]:
    """Return three standard normal values that depend on these arguments only."""
    generator = np.random.default_rng([seed, crc32(vehicle.encode()), stream, index])
    return tuple(generator.standard_normal(3).tolist())


_kept_normals = lru_cache(maxsize=256)(_normals)
