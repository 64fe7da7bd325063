# SPDX-License-Identifier: Apache-2.0
"""Flight at a velocity for some time, and the stop after it, within the limits of a vehicle."""

import math

import numpy as np

from rocsafe_geo.limits import require_finite, require_not_negative
from rocsafe_geo.motion.limits import MotionLimits
from rocsafe_geo.motion.state import Enu, MotionState
from rocsafe_geo.motion.stop import StopMotion

# Points of the quadrature of a path; a polynomial of 15th degree is integrated exactly.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


class VelocityMotion:
    """A change to a velocity, the flight at it, and a stop.

    In a frame that moves with the velocity the change is a stop, so that it is as fast as the
    limits allow, in any direction.

    Parameters
    ----------
    start
        State at time 0.
    velocity_enu
        Velocity to be flown, m/s.
    flown_s
        Time after which it stops, also if it has not reached the velocity yet, seconds.
    level, vertical
        Limits of the horizontal and the vertical motion.
    """

    def __init__(
        self,
        start: MotionState,
        velocity_enu: Enu,
        flown_s: float,
        level: MotionLimits,
        vertical: MotionLimits,
    ) -> None:
        for value in velocity_enu:
            require_finite('velocity_enu', value)
        self._velocity = velocity_enu
        self._flown_s = require_not_negative('flown_s', flown_s)
        relative = MotionState(
            start.position_enu,
            _minus(start.velocity_enu, velocity_enu),
            start.acceleration_enu,
        )
        self._change = StopMotion(relative, level, vertical, is_steered=True)
        self._stop = StopMotion(self._moving(self._flown_s), level, vertical)

    @property
    def duration_s(self) -> float:
        """Time at which it stands, seconds."""
        return self._flown_s + self._stop.duration_s

    @property
    def distance_m(self) -> float:
        """Horizontal length of the path, metres."""
        return self.progress_m(self.duration_s)

    @property
    def knots_s(self) -> list[float]:
        """Times between which the motion is a polynomial, ascending from 0."""
        change = [knot for knot in self._change.knots_s if knot < self._flown_s]
        return sorted(
            {*change, self._flown_s, *(self._flown_s + knot for knot in self._stop.knots_s)}
        )

    def state(self, elapsed_s: float) -> MotionState:
        """Return the motion at a time."""
        if elapsed_s < self._flown_s:
            return self._moving(max(0.0, elapsed_s))
        # The end is exactly still, whatever the rounding of the difference.
        is_over = elapsed_s >= self.duration_s
        return self._stop.state(math.inf if is_over else elapsed_s - self._flown_s)

    def progress_m(self, elapsed_s: float) -> float:
        """Return the horizontal length of the path until a time."""
        end_s = min(max(0.0, elapsed_s), self.duration_s)
        knots = [knot for knot in self.knots_s if knot < end_s] or [0.0]
        length_m = 0.0
        for begin_s, until_s in zip(knots, [*knots[1:], end_s], strict=True):
            middle_s, half_s = (begin_s + until_s) / 2.0, (until_s - begin_s) / 2.0
            speeds = [self.state(middle_s + half_s * float(node)).speed_mps for node in _NODES]
            length_m += half_s * float(np.dot(_WEIGHTS, speeds))
        return length_m

    def _moving(self, elapsed_s: float) -> MotionState:
        """Return the state at a time if there were no stop."""
        seen = self._change.state(elapsed_s)
        east, north, up = (
            place + speed * elapsed_s
            for place, speed in zip(seen.position_enu, self._velocity, strict=True)
        )
        return MotionState(
            (east, north, up), _plus(seen.velocity_enu, self._velocity), seen.acceleration_enu
        )


def _plus(a: Enu, b: Enu) -> Enu:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _minus(a: Enu, b: Enu) -> Enu:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]
