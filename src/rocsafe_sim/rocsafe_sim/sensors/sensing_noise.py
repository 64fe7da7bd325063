# SPDX-License-Identifier: Apache-2.0
"""Errors of the sensors of a vehicle, as functions of seed, vehicle, and time or number.

No generator is kept between calls. Errors depend neither on the order of calls nor on the speed of
a run, and a restarted process repeats them.
"""

import math
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from rocsafe_geo.motion.state import Enu
from rocsafe_sim.flight.sensing_options import SensingOptions
from rocsafe_sim.sensors.errors_over_time import Draws
from rocsafe_sim.sensors.streams import Stream

# Interval of the knots between which the error of the receiver varies slowly; a tenth of its
# variance is new in every fix.
KNOT_PERIOD_NS = 20_000_000_000
_WHITE_VARIANCE_SHARE = 0.1
# Largest sway: a vehicle that sways further does not release the shutter.
LARGEST_SWAY_STDS = 3.5

# Interval of the knots between which the sway of a stream varies.
SWAY_PERIOD_NS = 1_000_000_000


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

    @property
    def draws(self) -> Draws:
        """Random values of the vehicle."""
        return Draws(seed=self.seed, vehicle=self.vehicle)

    def gps_error_m(self, time_ns: int) -> Enu:
        """Return the error of the receiver (east, north, up) at a simulated time.

        At every time it is normal with the stated standard deviations. Values at knots are blended
        by cosine and sine, whose squares add up to 1.
        """
        knot, rest_ns = divmod(time_ns, KNOT_PERIOD_NS)
        turn = 0.5 * math.pi * rest_ns / KNOT_PERIOD_NS
        wander_share = math.sqrt(1.0 - _WHITE_VARIANCE_SHARE)
        early, late = wander_share * math.cos(turn), wander_share * math.sin(turn)
        draws = self.draws
        before, after = (
            draws.knot(Stream.GPS_WANDER, knot),
            draws.knot(Stream.GPS_WANDER, knot + 1),
        )
        white = draws.white(Stream.GPS_WHITE, time_ns)
        white_share = math.sqrt(_WHITE_VARIANCE_SHARE)
        east, north, up = (
            early * a + late * b + white_share * c
            for a, b, c in zip(before, after, white, strict=True)
        )
        horizontal = self.gps_horizontal_std_m
        return horizontal * east, horizontal * north, self.gps_vertical_std_m * up

    def sway_rad(self, sequence: int) -> tuple[float, float]:
        """Return true (roll, pitch) at the photograph with this number."""
        roll, pitch, _ = self.draws.white(Stream.SWAY, sequence)
        return self._swayed(roll, pitch)

    def sway_at_rad(self, time_ns: int) -> tuple[float, float]:
        """Return true (roll, pitch) at a simulated time, continuous, with the same deviations."""
        roll, pitch, _ = self.draws.drift(Stream.SWAY_WANDER, time_ns, SWAY_PERIOD_NS)
        return self._swayed(roll, pitch)

    def _swayed(self, roll: float, pitch: float) -> tuple[float, float]:
        # Both limits together keep the tilt, their hypotenuse, within LARGEST_SWAY_STDS.
        limit = LARGEST_SWAY_STDS / math.sqrt(2.0)
        roll, pitch = (min(max(value, -limit), limit) for value in (roll, pitch))
        return self.tilt_std_rad * roll, self.tilt_std_rad * pitch

    def attitude_error_rad(self, sequence: int) -> tuple[float, float, float]:
        """Return the error of measured (roll, pitch, yaw) at the photograph with this number."""
        roll, pitch, yaw = self.draws.white(Stream.ATTITUDE, sequence)
        std = self.attitude_std_rad
        return std * roll, std * pitch, std * yaw

    def picture_rng(self, camera: str, time_ns: int) -> np.random.Generator:
        """Return the generator of the noise of an image."""
        key = [self.seed, crc32(self.vehicle.encode()), crc32(camera.encode()), time_ns]
        return np.random.default_rng(key)


def sensor_noise(options: SensingOptions, name: str) -> SensorNoise:
    """Return the errors of the sensors of the vehicle `name`."""
    return SensorNoise(
        seed=options.seed,
        vehicle=name,
        gps_horizontal_std_m=options.gps_horizontal_std_m,
        gps_vertical_std_m=options.gps_vertical_std_m,
        tilt_std_rad=math.radians(options.tilt_std_deg),
        attitude_std_rad=math.radians(options.attitude_std_deg),
    )
