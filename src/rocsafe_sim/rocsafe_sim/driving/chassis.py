# SPDX-License-Identifier: Apache-2.0
"""The chassis of a simulated ground vehicle: size, motion, skid and power.

Skid is a function of seed, vehicle and time, so that neither the speed of a run nor a restart
changes a drive.
"""

import math
from dataclasses import dataclass, field
from functools import lru_cache
from zlib import crc32

import numpy as np

from rocsafe_geo.limits import require_between, require_not_negative, require_positive
from rocsafe_geo.motion.ground_motion import GroundMotion
from rocsafe_geo.time_units import NS_PER_S

GRAVITY_MPS2 = 9.81
# Interval between the knots of the skid: ground changes within about a metre.
KNOT_NS = NS_PER_S
_STREAM = 17


@dataclass(frozen=True, slots=True, kw_only=True)
class Chassis:
    """A tracked robot of 50 kg.

    Attributes
    ----------
    motion
        Acceleration and rate of turn.
    width_m
        Across the tracks: nothing may stand so near its middle.
    mass_kg, rolling_w_s_per_m, idle_w
        Weight, power per speed on level ground, and power at rest. Rolling resistance of tracks
        on soil is about a tenth of the weight.
    drive_w
        Power of the motors: up steep slopes it does not reach every speed limit.
    endurance_s
        Driving time at 1 m/s on level ground on a full battery, with the reserve.
    reserve_fraction
        Charge with which it comes back.
    slip_fraction, slip_std
        Mean and deviation of the part of the tracks' speed that is lost on the ground.
    drift_std_mps
        Deviation of the sideward speed while it drives at 1 m/s.
    """

    motion: GroundMotion = field(default_factory=GroundMotion)
    width_m: float = 0.7
    mass_kg: float = 50.0
    rolling_w_s_per_m: float = 50.0
    idle_w: float = 30.0
    drive_w: float = 250.0
    endurance_s: float = 8000.0
    reserve_fraction: float = 0.1
    slip_fraction: float = 0.02
    slip_std: float = 0.01
    drift_std_mps: float = 0.02

    def __post_init__(self) -> None:
        require_between('width_m', self.width_m, 0.1, 10.0, 'm')
        require_positive('endurance_s', self.endurance_s, 's')
        require_positive('drive_w', self.drive_w, 'W')
        for name in ('mass_kg', 'rolling_w_s_per_m', 'idle_w', 'drift_std_mps'):
            require_not_negative(name, getattr(self, name))
        for name in ('reserve_fraction', 'slip_fraction', 'slip_std'):
            require_between(name, getattr(self, name), 0.0, 0.9)

    @property
    def capacity_j(self) -> float:
        """Energy of a full battery."""
        return self.endurance_s * self.power_w(1.0, 0.0)

    def power_w(self, speed_mps: float, grade: float) -> float:
        """Return the power at a speed on a slope, as rise over run; braking gives none back."""
        climb = self.mass_kg * GRAVITY_MPS2 * math.sin(math.atan(grade)) * speed_mps
        return self.idle_w + max(0.0, self.rolling_w_s_per_m * speed_mps + climb)

    def fastest_mps(self, grade: float) -> float:
        """Return the speed that the motors have the power for on a slope, as rise over run."""
        force = self.rolling_w_s_per_m + self.mass_kg * GRAVITY_MPS2 * math.sin(math.atan(grade))
        return self.drive_w / force if force > 0.0 else math.inf


@dataclass(frozen=True, slots=True, kw_only=True)
class Skid:
    """How the ground lets one vehicle slip.

    Attributes
    ----------
    chassis
        With the deviations.
    seed
        Of the run.
    vehicle
        Its name.
    """

    chassis: Chassis
    seed: int
    vehicle: str

    def at(self, time_ns: int) -> tuple[float, float]:
        """Return the part of the speed that is lost, and the sideward speed at 1 m/s."""
        knot, rest_ns = divmod(time_ns, KNOT_NS)
        share = rest_ns / KNOT_NS
        before, after = (_normals(self.seed, self.vehicle, k) for k in (knot, knot + 1))
        slip, drift = ((1.0 - share) * a + share * b for a, b in zip(before, after, strict=True))
        chassis = self.chassis
        lost = chassis.slip_fraction + chassis.slip_std * slip
        return min(max(lost, 0.0), 0.9), chassis.drift_std_mps * drift


@lru_cache(maxsize=64)
def _normals(seed: int, vehicle: str, knot: int) -> tuple[float, float]:
    generator = np.random.default_rng([seed, crc32(vehicle.encode()), _STREAM, knot])
    slip, drift = generator.standard_normal(2).tolist()
    return slip, drift
