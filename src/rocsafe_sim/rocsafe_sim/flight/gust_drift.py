# SPDX-License-Identifier: Apache-2.0
"""How far gusts push a vehicle off its way while its autopilot holds against them.

A gust accelerates a vehicle by the change of its drag. The autopilot holds the way with the
controllers of ArduCopter: a position error asks for a speed, a speed error and its integral for an
acceleration. From the acceleration of the gust to the offset that is the transfer function
s / (s^3 + P s^2 + (P Q + I) s + I Q). The gusts are those of the air
(`rocsafe_geo.wind.gusts`), so that the wind that carries gas is the one that pushes the vehicles.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_count, require_not_negative, require_positive
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_geo.wind.gusts import correlated_noise

# PSC_VELXY_P, PSC_POSXY_P and PSC_VELXY_I of ArduCopter 4: P, Q and I above.
_SPEED_GAIN, _PLACE_GAIN, _INTEGRAL_GAIN = 2.0, 1.0, 1.0
# Gusts count every so many seconds, and until their response has died away.
_STEP_S, _MEMORY_S = 0.1, 16.0
_NO_OFFSET = ((0.0, 0.0), (0.0, 0.0))

Flat = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class GustDrift:
    """Offsets of a vehicle from its way as a pure function of time: the same after a restart.

    Attributes
    ----------
    std_mps
        Standard deviation of the gusts towards east and north each, m/s; 0: no gusts.
    scale_s
        Time in which their correlation falls to 1/e, seconds.
    seed
        Seed of the gusts, that of the air.
    start_ns
        Start of the mission, from which the time of the gusts counts, nanoseconds.
    drag_per_m
        Deceleration by drag over the square of the airspeed, 1/m.
    wind_mps
        Mean wind, towards east and north.
    """

    std_mps: float
    scale_s: float
    seed: int
    start_ns: int
    drag_per_m: float
    wind_mps: Flat

    def __post_init__(self) -> None:
        require_not_negative('gust_std_mps', self.std_mps, 'm/s')
        require_positive('gust_scale_s', self.scale_s, 's')
        require_positive('drag_per_m', self.drag_per_m, '1/m')
        require_count('seed', self.seed, 0, 2**63 - 1)

    def at(self, time_ns: int, velocity_mps: Flat) -> tuple[Flat, Flat]:
        """Return the offset, metres, and its rate, m/s, towards east and north.

        Parameters
        ----------
        time_ns
            Simulated time, nanoseconds.
        velocity_mps
            Velocity along the way at that time: drag grows with the airspeed.
        """
        if not self.std_mps:
            return _NO_OFFSET
        step = (time_ns - self.start_ns) / NS_PER_S / _STEP_S
        index = math.floor(step)
        share = step - index
        before, after = (_response(self.seed, self.scale_s, index + k) for k in (0, 1))
        air = np.array(velocity_mps) - self.wind_mps
        speed = math.hypot(air[0], air[1], self.std_mps)
        # Derivative of the drag -d |v| v with respect to the wind, of two directions.
        push = self.drag_per_m * self.std_mps * (speed * np.eye(2) + np.outer(air, air) / speed)
        offset, rate = ((1.0 - share) * before + share * after) @ push
        return (float(offset[0]), float(offset[1])), (float(rate[0]), float(rate[1]))


@lru_cache(maxsize=1024)
def _response(seed: int, scale_s: float, index: int) -> FloatArray:
    """Return offset and rate for gusts of 1 m/s that accelerate by 1 m/s^2, (2, 2)."""
    count = len(_kernels()[0])
    gusts = np.array([_gust(seed, scale_s, index - age) for age in range(count)])
    return np.asarray(_kernels() @ gusts)


@lru_cache(maxsize=4096)
def _gust(seed: int, scale_s: float, index: int) -> FloatArray:
    return correlated_noise(seed, index * _STEP_S / scale_s)[:2]


@lru_cache(maxsize=1)
def _kernels() -> FloatArray:
    """Return the responses of offset and rate to a push of one step, by its age, (2, ages)."""
    ages = np.arange(0.0, _MEMORY_S, _STEP_S)
    denominator = np.array([
        1.0, _SPEED_GAIN, _SPEED_GAIN * _PLACE_GAIN + _INTEGRAL_GAIN, _INTEGRAL_GAIN * _PLACE_GAIN
    ])  # fmt: skip
    poles = np.roots(denominator)
    shares = poles / np.polyval(np.polyder(denominator), poles)
    modes = shares[:, None] * np.exp(poles[:, None] * ages)
    found = np.real([modes.sum(axis=0), (poles[:, None] * modes).sum(axis=0)]) * _STEP_S
    found[:, 0] /= 2.0  # trapezoids
    return np.asarray(found)
