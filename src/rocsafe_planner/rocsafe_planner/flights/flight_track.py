# SPDX-License-Identifier: Apache-2.0
"""Where a vehicle is at any time of its route, in the planner's time model."""

from functools import cached_property

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_planner.problem.fleet_problem import FleetProblem, Order

# In a corner two legs overlap: their speeds add up to a little more than the limit of each.
_CORNER_HASTE = 1.5


class FlightTrack:
    """The motions of a vehicle's flights by one clock.

    Attributes
    ----------
    windows
        (begin, end) of the times in the air, shape (flights, 2), seconds since first take-off.
    is_aloft
        Whether it begins in the air. It waits there, on its battery.
    keeps_to_batteries
        Whether no flight takes longer than its battery lasts.
    longest_wait_s
        Time that it can wait before it flies, seconds.
    top_speed_mps
        That it never exceeds, climb and descent included.
    low, high
        Corners (east, north, up) of the box that it stays in.
    """

    def __init__(self, problem: FleetProblem, vehicle: int, flights: list[Order]) -> None:
        spec = problem.vehicles[vehicle]
        last = len(flights) - 1
        self._motions = [
            problem.kept_motion(vehicle, order, is_first=number == 0, is_last=number == last)
            for number, order in enumerate(flights)
        ]
        swap_s = spec.battery_swap_s or 0.0
        durations = np.array([motion.duration_s for motion in self._motions])
        ends = np.cumsum(durations + swap_s) - swap_s
        self.windows: FloatArray = np.column_stack([ends - durations, ends]).reshape(-1, 2)
        self.is_aloft = spec.aloft is not None
        limits = np.full(len(durations), spec.endurance_s)
        limits[:1] = spec.first_endurance_s
        self.keeps_to_batteries = bool((durations <= limits).all())
        left_s = spec.first_endurance_s - float(durations[0])
        self.longest_wait_s = max(0.0, left_s) if self.is_aloft else np.inf
        places = [place for motion in self._motions for place in motion.places_enu]
        self.low, self.high = np.min(places, axis=0), np.max(places, axis=0)
        flight = problem.flight(vehicle)
        level = flight.fastest().cruise_speed_mps * (_CORNER_HASTE if flight.passes else 1.0)
        self.top_speed_mps = float(
            np.hypot(level, max(spec.climb_rate_mps, spec.descent_rate_mps))
        )

    def ways(self) -> list[FloatArray]:
        """Return the corners (east, north, up) of each flight, climb and descent included."""
        return [np.asarray(motion.places_enu) for motion in self._motions]

    @property
    def duration_s(self) -> float:
        """Time from the first take-off to the last touch-down."""
        return float(self.windows[-1, 1])

    @cached_property
    def samples(self) -> tuple[IndexArray, FloatArray]:
        """Whole seconds in the air, shape (n,), and the places at them, shape (n, 3)."""
        spans = [np.arange(int(np.ceil(a)), int(b) + 1) for a, b in self.windows.tolist()]
        times = np.concatenate(spans)
        return times, self.places(times.astype(np.float64))

    def windows_after(self, wait_s: float) -> FloatArray:
        """Return the times in the air of a vehicle that waits before its first flight."""
        if not self.is_aloft:
            return self.windows
        windows = self.windows.copy()
        windows[0, 0] -= wait_s
        return windows

    def places(self, times_s: FloatArray) -> FloatArray:
        """Return (east, north, up) at times in the air, shape (n, 3); before 0 it stands."""
        begins = self.windows[:, 0]
        flight = np.clip(np.searchsorted(begins, times_s, side='right') - 1, 0, None)
        places = np.empty((len(times_s), 3))
        for number in np.unique(flight).tolist():
            chosen = flight == number
            since_s = np.maximum(times_s[chosen] - begins[number], 0.0)
            places[chosen] = self._motions[number].positions(since_s)
        return places
