# SPDX-License-Identifier: Apache-2.0
"""The dose of a real ground vehicle on its drive: it is called home in time.

A simulated one judges its readings itself, by the same rule.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

from rocsafe_geo.motion.dose_reserve import DoseOutlook, ReserveOptions, dose_reason
from rocsafe_geo.position import GeoPosition, distance_m

# A stop is behind a vehicle that has been so near to it.
PASSED_M = 1.5
# Slower than this it stands: what it takes is not taken again on the way back.
MOVING_MPS = 0.1
# Readings over which the growth of the dose rate is looked at, and a gap that is not added up.
RATES_KEPT, LONGEST_GAP_S = 10, 5.0
# Lines whose mean dose rate is so many times higher are much hotter.
HOTTER = 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class WatchedStop:
    """A stop of a drive, with the time (s) and dose (uSv) of the line to it and its stand."""

    place: GeoPosition
    duration_s: float
    dose_usv: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A dose rate that the vehicle has read, where, when, and how fast it was."""

    stamp_s: float
    rate_usvh: float
    place: GeoPosition
    speed_mps: float


class DriveWatch:
    """Adds up the readings of a drive, and tells when it must end.

    Parameters
    ----------
    stops
        Of the route; the first is where it begins.
    budget_usv, turn_back_usvh
        Limits of the route.
    upper_ratio
        Upper 95 % of its predicted dose over the mean; 0: nobody told.
    taken_usv
        Of the budget, before it began to drive.

    Attributes
    ----------
    dose_usv, duration_s
        What it has taken, and how long it has driven, by its readings.
    """

    def __init__(
        self,
        stops: Sequence[WatchedStop],
        budget_usv: float,
        turn_back_usvh: float,
        upper_ratio: float = 0.0,
        taken_usv: float = 0.0,
    ) -> None:
        self._stops, self._next = tuple(stops), 1
        self._budget_usv, self._turn_back_usvh = budget_usv, turn_back_usvh
        self._upper_ratio = upper_ratio
        self._last: Reading | None = None
        self.dose_usv, self.duration_s, self._back_usv = taken_usv, 0.0, 0.0
        self._rates: deque[float] = deque(maxlen=RATES_KEPT)

    def read(self, now: Reading) -> str:
        """Take a reading; return why the vehicle must come home, empty if it need not."""
        before, self._last = self._last, now
        if before is None or now.stamp_s <= before.stamp_s:
            return ''
        gap_s = now.stamp_s - before.stamp_s
        self.duration_s += gap_s
        if gap_s <= LONGEST_GAP_S:
            dose = 0.5 * (now.rate_usvh + before.rate_usvh) * gap_s / 3600.0
            self.dose_usv += dose
            self._back_usv += dose if now.speed_mps >= MOVING_MPS else 0.0
        self._rates.append(now.rate_usvh)
        while self._next < len(self._stops) - 1 and self._is_passed(now.place):
            self._next += 1
        return dose_reason(self._outlook(now), ReserveOptions())

    def _is_passed(self, place: GeoPosition) -> bool:
        return distance_m(place, self._stops[self._next].place) <= PASSED_M

    def _outlook(self, now: Reading) -> DoseOutlook:
        stop, before = self._stops[self._next], self._stops[self._next - 1]
        length = max(distance_m(before.place, stop.place), 1e-6)
        share = 1.0 - min(distance_m(now.place, stop.place) / length, 1.0)
        done = sum(one.dose_usv for one in self._stops[: self._next]) + share * stop.dose_usv
        total = sum(one.dose_usv for one in self._stops)
        ahead, behind = self._stops[self._next + 1 :], self._stops[1 : self._next + 1]
        return DoseOutlook(
            budget_usv=self._budget_usv,
            turn_back_usvh=self._turn_back_usvh,
            dose_usv=self.dose_usv,
            rate_usvh=now.rate_usvh,
            growth=now.rate_usvh / max(self._rates[0], 1e-9),
            predicted_usv=done,
            rest_usv=total - done,
            is_rest_hotter=_peak(ahead) > HOTTER * _peak(behind),
            hotter_ratio=self._upper_ratio,
            back_usv=self._back_usv,
        )


def _peak(stops: Sequence[WatchedStop]) -> float:
    """Return the highest mean dose rate that is predicted for a line, microsievert a second."""
    return max((one.dose_usv / max(one.duration_s, 1e-9) for one in stops), default=0.0)
