# SPDX-License-Identifier: Apache-2.0
"""The stop of a vehicle from any motion, as fast as its limits allow."""

import math
from bisect import bisect_right
from dataclasses import replace
from itertools import accumulate

from rocsafe_geo.motion.limits import MotionLimits
from rocsafe_geo.motion.state import MotionState

Vector = tuple[float, ...]
_Phase = tuple[float, Vector]
"""Duration of a phase, seconds, and its jerk."""

# Share of the speed lost while a deceleration falls to zero that may be rounding.
_OVERSHOOT = 1e-3
# A vehicle slower than this stands; rounding leaves such speeds.
_STANDING_MPS = 1e-9
# Sine of the angle between a velocity and an acceleration that may be rounding.
_STRAIGHT = 1e-6
# Two perpendicular parts as large are together within the whole.
_HALF_EACH = math.sqrt(0.5)


class StopMotion:
    """Braking to standstill, horizontally and vertically independent of each other.

    An acceleration across the velocity is reduced to zero first. The jerk changes in steps.

    Parameters
    ----------
    start
        State at time 0.
    level, vertical
        Limits of the horizontal and the vertical motion.
    is_steered
        Whether an acceleration across the velocity is used instead, east and north each by
        itself within limits that both together keep. A stop that is asked for anew all the time,
        with another velocity, gets nowhere otherwise: it would begin with the reduction each time.
    """

    def __init__(
        self,
        start: MotionState,
        level: MotionLimits,
        vertical: MotionLimits,
        *,
        is_steered: bool = False,
    ) -> None:
        p, v, a = start.position_enu, start.velocity_enu, start.acceleration_enu
        can_steer = is_steered and _can_steer(v[:2], a[:2], level)
        braking = _SteeredBraking if can_steer else _Braking
        self._level: _Braking | _SteeredBraking = braking(p[:2], v[:2], a[:2], level)
        self._vertical = _Braking(p[2:], v[2:], a[2:], vertical)
        self._start = p

    @property
    def duration_s(self) -> float:
        """Time at which it stands, seconds."""
        return max(self._level.duration_s, self._vertical.duration_s)

    @property
    def distance_m(self) -> float:
        """Horizontal distance from begin to end, metres."""
        return self.progress_m(self.duration_s)

    @property
    def knots_s(self) -> list[float]:
        """Times between which the motion is a polynomial, ascending from 0."""
        level, vertical = self._level, self._vertical
        ends = {level.duration_s, vertical.duration_s}
        return sorted({*level.begins, *vertical.begins, *ends})

    def state(self, elapsed_s: float) -> MotionState:
        """Return the motion at a time."""
        level, vertical = self._level.at(elapsed_s), self._vertical.at(elapsed_s)
        position, velocity, acceleration = (
            (a[0], a[1], b[0]) for a, b in zip(level, vertical, strict=True)
        )
        return MotionState(position, velocity, acceleration)

    def progress_m(self, elapsed_s: float) -> float:
        """Return the horizontal distance from the begin until a time."""
        east, north = self._level.at(elapsed_s)[0]
        return math.hypot(east - self._start[0], north - self._start[1])


class _Braking:
    """Phases of constant jerk, in one dimension or two.

    Attributes
    ----------
    begins
        Begins of the phases, seconds.
    """

    def __init__(
        self, position: Vector, velocity: Vector, acceleration: Vector, limits: MotionLimits
    ) -> None:
        phases = _phases(velocity, acceleration, limits)
        self._jerks = [jerk for _, jerk in phases]
        self.begins = list(accumulate((duration for duration, _ in phases), initial=0.0))
        self.duration_s = self.begins.pop()
        states = [(position, velocity, acceleration)]
        for duration, jerk in phases:
            states.append(_after(states[-1], jerk, duration))
        still = tuple(0.0 for _ in position)
        self._end = (states.pop()[0], still, still)
        self._states = states

    def at(self, elapsed_s: float) -> tuple[Vector, Vector, Vector]:
        """Return position, velocity and acceleration."""
        if elapsed_s >= self.duration_s or not self._states:
            return self._end
        elapsed = max(0.0, elapsed_s)
        phase = bisect_right(self.begins, elapsed) - 1
        return _after(self._states[phase], self._jerks[phase], elapsed - self.begins[phase])


class _SteeredBraking:
    """Phases of constant jerk east and north, independent of each other."""

    def __init__(
        self, position: Vector, velocity: Vector, acceleration: Vector, limits: MotionLimits
    ) -> None:
        share = replace(
            limits,
            acceleration_mps2=limits.acceleration_mps2 * _HALF_EACH,
            jerk_mps3=limits.jerk_mps3 * _HALF_EACH,
        )
        axes = zip(position, velocity, acceleration, strict=True)
        self._axes = [_Braking((x,), (v,), (a,), share) for x, v, a in axes]
        self.begins = sorted(
            {time for axis in self._axes for time in (*axis.begins, axis.duration_s)}
        )
        self.duration_s = max(axis.duration_s for axis in self._axes)

    def at(self, elapsed_s: float) -> tuple[Vector, Vector, Vector]:
        """Return position, velocity and acceleration."""
        (x, v, a), (y, w, b) = (axis.at(elapsed_s) for axis in self._axes)
        return (*x, *y), (*v, *w), (*a, *b)


def _can_steer(velocity: Vector, acceleration: Vector, limits: MotionLimits) -> bool:
    """Return whether an acceleration is across a velocity, and within the share of each axis."""
    across = velocity[0] * acceleration[1] - velocity[1] * acceleration[0]
    size = math.hypot(*velocity) * math.hypot(*acceleration)
    most = max(map(abs, acceleration))
    return abs(across) > _STRAIGHT * size and most <= limits.acceleration_mps2 * _HALF_EACH


def _after(
    state: tuple[Vector, Vector, Vector], jerk: Vector, t: float
) -> tuple[Vector, Vector, Vector]:
    rows = list(zip(*state, jerk, strict=True))
    return (
        tuple(x + t * (v + t * (a / 2.0 + t * j / 6.0)) for x, v, a, j in rows),
        tuple(v + t * (a + t * j / 2.0) for _, v, a, j in rows),
        tuple(a + t * j for _, _, a, j in rows),
    )


def _phases(velocity: Vector, acceleration: Vector, limits: MotionLimits) -> list[_Phase]:
    """Return the phases that bring a motion to standstill."""
    still = tuple(0.0 for _ in velocity)
    first: list[_Phase] = []
    speed = math.hypot(*velocity)
    along = _dot(acceleration, velocity) / speed if speed > _STANDING_MPS else 0.0
    size = math.hypot(*acceleration)
    lost = along**2 / (2.0 * limits.jerk_mps3) if along < 0.0 else 0.0
    if size - abs(along) > 1e-9 * (1.0 + size) or speed < lost * (1.0 - _OVERSHOOT):
        # The acceleration is not along the velocity, or brakes beyond standstill: reduce all of
        # it to zero first.
        rest_s = size / limits.jerk_mps3
        jerk = _scaled(acceleration, -limits.jerk_mps3 / size)
        _, velocity, _ = _after((still, velocity, acceleration), jerk, rest_s)
        first, along, speed = [(rest_s, jerk)], 0.0, math.hypot(*velocity)
    if speed <= _STANDING_MPS:
        return first
    backwards = _scaled(velocity, -1.0 / speed)
    return [
        *first,
        *((duration, _scaled(backwards, jerk)) for duration, jerk in _brake(speed, along, limits)),
    ]


def _brake(speed: float, acceleration: float, limits: MotionLimits) -> list[tuple[float, float]]:
    """Return durations and backward jerks of a stop from a speed and an acceleration along it.

    The deceleration rises to a peak, stays there if that is the largest allowed, and falls to zero
    together with the speed. Counted from zero acceleration, the speed to be braked is
    v + a |a| / 2j.
    """
    jerk = limits.jerk_mps3
    from_rest = speed + acceleration**2 / (2.0 * jerk)
    if acceleration < 0.0:
        # It has at least the speed that is lost while its deceleration falls to zero.
        from_rest = max(from_rest, acceleration**2 / jerk)
    peak = min(max(limits.acceleration_mps2, -acceleration), math.sqrt(jerk * from_rest))
    rest_s = max(0.0, (from_rest - peak**2 / jerk) / peak)
    return [
        (max(0.0, (peak + acceleration) / jerk), jerk),
        (rest_s, 0.0),
        (peak / jerk, -jerk),
    ]


def _dot(a: Vector, b: Vector) -> float:
    return sum(x * y for x, y in zip(a, b, strict=True))


def _scaled(vector: Vector, factor: float) -> Vector:
    return tuple(factor * value for value in vector)
