# SPDX-License-Identifier: Apache-2.0
"""How far the wind pushes a vehicle off its way while its autopilot holds against it.

The autopilot knows the mean wind. Where and when the air moves otherwise, in gusts, behind houses
or by a record, the change of the drag accelerates the vehicle. The autopilot holds the way with
the controllers of ArduCopter: a position error asks for a speed, a speed error and its integral
for an acceleration. From the acceleration by the air to the offset that is the transfer function
s / (s^3 + P s^2 + (P Q + I) s + I Q). The wind is the one that carries gas
(`rocsafe_geo.wind.mission_wind`).
"""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_positive
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_geo.wind.site_wind import SiteWind
from rocsafe_geo.wind.wind_field import WindField
from rocsafe_sim.flight.segment import FlightPose

# PSC_VELXY_P, PSC_POSXY_P and PSC_VELXY_I of ArduCopter 4: P, Q and I above.
_SPEED_GAIN, _PLACE_GAIN, _INTEGRAL_GAIN = 2.0, 1.0, 1.0
# The wind counts every so many seconds, and until its response has died away.
_STEP_S, _MEMORY_S = 0.1, 16.0
_STEP_NS = round(_STEP_S * NS_PER_S)
# Pushes that are kept; older ones are made again if they are asked for.
_KEPT = 1024

Flat = tuple[float, float]


class WindDrift:
    """Offsets of a vehicle from its way as a function of time and way: the same after a restart.

    Parameters
    ----------
    wind
        The wind; its places are about the origin of the vehicle's frame, its time counts from
        `start_ns`.
    start_ns
        Start of the mission, nanoseconds.
    drag_per_m
        Deceleration by drag over the square of the airspeed, 1/m.
    mean_mps
        Mean wind, towards east and north, which the autopilot holds against without an offset.
    """

    def __init__(self, wind: WindField, start_ns: int, drag_per_m: float, mean_mps: Flat) -> None:
        self._wind, self._start_ns = wind, start_ns
        self._drag_per_m = require_positive('drag_per_m', drag_per_m, '1/m')
        self._mean = np.array(mean_mps)
        self._command: object = None
        self._pushes: dict[int, FloatArray] = {}
        self._responses: dict[int, FloatArray] = {}

    def at(
        self, time_ns: int, way: Callable[[int], FlightPose], command: object
    ) -> tuple[Flat, Flat]:
        """Return the offset, metres, and its rate, m/s, towards east and north.

        Parameters
        ----------
        time_ns
            Simulated time, nanoseconds.
        way
            Pose on its way without the offset, of the time in nanoseconds.
        command
            The command that the way follows from: while it is the same, so is the way.
        """
        if command is not self._command or len(self._pushes) > _KEPT:
            self._command = command
            self._pushes.clear()
            self._responses.clear()
        index, rest_ns = divmod(time_ns - self._start_ns, _STEP_NS)
        share = rest_ns / _STEP_NS
        before, after = (self._response(index + k, way) for k in (0, 1))
        offset, rate = (1.0 - share) * before + share * after
        return (float(offset[0]), float(offset[1])), (float(rate[0]), float(rate[1]))

    def _response(self, index: int, way: Callable[[int], FlightPose]) -> FloatArray:
        """Return offset and rate at the end of a step, (2, 2)."""
        if index not in self._responses:
            recent = range(index, index - _kernels().shape[1], -1)
            for each in recent:
                if each not in self._pushes:
                    self._pushes[each] = self._push(each, way(self._start_ns + each * _STEP_NS))
            pushes = np.array([self._pushes[each] for each in recent])
            self._responses[index] = np.asarray(_kernels() @ pushes)
        return self._responses[index]

    def _push(self, index: int, pose: FlightPose) -> FloatArray:
        """Return the acceleration by the air that the mean wind does not explain, m/s^2."""
        place = np.array([pose.position_enu])
        if isinstance(self._wind, SiteWind):
            place[:, 2] -= self._wind.ground_up_m(place[:, :2])
        place[:, 2] = np.maximum(place[:, 2], 0.0)
        moving = np.array(pose.velocity_enu[:2])
        found = self._wind.velocities_mps(index * _STEP_S, place)[0, :2]
        return self._drag_per_m * (_squared(moving - self._mean) - _squared(moving - found))


def _squared(airspeed: FloatArray) -> FloatArray:
    """Return an airspeed times its size: the drag goes with it."""
    return np.asarray(math.hypot(*airspeed.tolist()) * airspeed)


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
