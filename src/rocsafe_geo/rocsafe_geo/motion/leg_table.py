# SPDX-License-Identifier: Apache-2.0
"""Tables of polynomials: distance, speed and acceleration along legs at any time.

Along a leg the jerk is constant or changes linearly. A leg has fifteen such pieces, each a
polynomial of fourth degree in the time since its begin.
"""

from bisect import bisect_right

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.motion.leg import Legs

PIECES = 15
# Jerk at the begin of each piece and its change, both as parts of the jerk of the leg.
_JERK = (0, 1, 1, 0, 0, -1, -1, 0, 0, -1, -1, 0, 0, 1, 1)
_RISE = (1, 0, -1, 0, -1, 0, 1, 0, -1, 0, 1, 0, 1, 0, -1)

Along = tuple[float, float, float]
"""Distance from the start (m), speed (m/s) and acceleration (m/s^2) along a leg."""


class LegTable:
    """The motion along legs; `legs` holds arrays of shape (n,).

    Attributes
    ----------
    begin_s
        Begin of each piece since the start of its leg, seconds, shape (n, 15).
    coefficients
        Coefficients of each piece, ascending, shape (n, 15, 5).
    """

    def __init__(self, legs: Legs) -> None:
        self.legs = legs
        durations = _durations(legs)
        ends = np.cumsum(durations, axis=1)
        self.begin_s: FloatArray = np.hstack([np.zeros((len(ends), 1)), ends[:, :-1]])
        self.coefficients: FloatArray = _coefficients(legs, durations)
        self._begins = self.begin_s.tolist()
        self._pieces = self.coefficients.tolist()
        self._distances = legs.distance_m.tolist()
        self._ends = legs.duration_s.tolist()

    def at(self, leg: int, elapsed_s: float) -> Along:
        """Return the motion along one leg: standing before its start and after its end."""
        if elapsed_s <= 0.0:
            return 0.0, 0.0, 0.0
        if elapsed_s >= self._ends[leg]:
            return self._distances[leg], 0.0, 0.0
        begins = self._begins[leg]
        piece = bisect_right(begins, elapsed_s) - 1
        x, v, a, j, s = self._pieces[leg][piece]
        t = elapsed_s - begins[piece]
        return (
            x + t * (v + t * (a + t * (j + t * s))),
            v + t * (2.0 * a + t * (3.0 * j + t * 4.0 * s)),
            2.0 * a + t * (6.0 * j + t * 12.0 * s),
        )

    def progress_m(self, leg: IndexArray, elapsed_s: FloatArray) -> FloatArray:
        """Return the distances flown along legs, arrays (k,)."""
        t, (x, v, a, j, s) = self._pieces_at(leg, elapsed_s)
        progress = x + t * (v + t * (a + t * (j + t * s)))
        distance = self.legs.distance_m[leg]
        is_done = elapsed_s >= self.legs.duration_s[leg]
        return np.where(is_done, distance, np.clip(progress, 0.0, distance))

    def _pieces_at(self, leg: IndexArray, elapsed_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return time since the begin of the piece, and its coefficients, shape (5, k)."""
        elapsed = np.maximum(elapsed_s, 0.0)
        begins = self.begin_s[leg]
        piece = (begins <= elapsed[:, None]).sum(axis=1) - 1
        time = elapsed - begins[np.arange(len(leg)), piece]
        return time, self.coefficients[leg, piece].T


def _durations(legs: Legs) -> FloatArray:
    """Return the durations of all pieces, shape (n, 15)."""
    a, j, s = legs.acceleration_mps2, legs.jerk_mps3, legs.smoothing_s
    rise = np.divide(a, j, out=np.zeros_like(a), where=j > 0.0)
    full_jerk = np.maximum(0.0, rise - s)
    full = np.divide(legs.speed_mps, a, out=np.zeros_like(a), where=a > 0.0)
    rest = np.maximum(0.0, full - rise - s)
    cruise = np.maximum(0.0, legs.duration_s - 2.0 * legs.ramp_s)
    ramp = (s, full_jerk, s, rest, s, full_jerk, s)
    return np.column_stack([*ramp, cruise, *ramp])


def _coefficients(legs: Legs, durations: FloatArray) -> FloatArray:
    """Return the coefficients of all pieces, integrated from standstill, shape (n, 15, 5)."""
    jerk = legs.jerk_mps3
    snap = np.divide(jerk, legs.smoothing_s, out=np.zeros_like(jerk), where=legs.smoothing_s > 0)
    x, v, a = np.zeros((3, len(jerk)))
    table = np.empty((len(jerk), PIECES, 5))
    for piece in range(PIECES):
        t, j, s = durations[:, piece], _JERK[piece] * jerk, _RISE[piece] * snap
        table[:, piece] = np.column_stack([x, v, a / 2.0, j / 6.0, s / 24.0])
        x = x + t * (v + t * (a / 2.0 + t * (j / 6.0 + t * s / 24.0)))
        v = v + t * (a + t * (j / 2.0 + t * s / 6.0))
        a = a + t * (j + t * s / 2.0)
    return table
