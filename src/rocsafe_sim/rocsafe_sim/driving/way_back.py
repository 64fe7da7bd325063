# SPDX-License-Identifier: Apache-2.0
"""The way back that a ground vehicle knows: its own tracks, without the loops.

Where it has driven it can drive again, and it has measured the dose of it: no map is needed.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

# Distance between marks on the way, and distance to an older mark at which a loop is cut off.
MARK_M, JOIN_M = 0.5, 0.4
# Marks so near along the way are no loop.
LATEST_MARKS = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A place that was driven over.

    Attributes
    ----------
    east_m, north_m
        By the vehicle's own receiver.
    limit_mps
        Speed limit there.
    dose_usv
        Measured between it and the next mark, in motion.
    seconds
        Driving time to the next mark.
    """

    east_m: float
    north_m: float
    limit_mps: float
    dose_usv: float = 0.0
    seconds: float = 0.0

    @property
    def place(self) -> tuple[float, float]:
        """East and north."""
        return self.east_m, self.north_m


class WayBack:
    """Marks from where a drive began to where the vehicle is.

    Attributes
    ----------
    marks
        The first is where it comes back to.
    """

    def __init__(self, marks: Sequence[Mark]) -> None:
        self.marks = list(marks)

    @property
    def dose_usv(self) -> float:
        """What the way back takes, as it was measured on the way there."""
        return sum(mark.dose_usv for mark in self.marks)

    def energy_j(self, power_w: Callable[[float], float]) -> float:
        """Return what the way back takes, given the power at a speed."""
        return sum(mark.seconds * power_w(mark.limit_mps) for mark in self.marks)

    @property
    def homeward(self) -> tuple[Mark, ...]:
        """Marks from the last one to the first."""
        return tuple(reversed(self.marks))

    def note(self, place: tuple[float, float], limit_mps: float, seconds: float) -> None:
        """Note where the vehicle is after a time of driving; cut off a loop that ends there."""
        last = self.marks[-1]
        self.marks[-1] = replace(last, seconds=last.seconds + seconds)
        if math.dist(last.place, place) < MARK_M:
            return
        for number, mark in enumerate(self.marks[:-LATEST_MARKS]):
            if math.dist(mark.place, place) < JOIN_M:
                del self.marks[number + 1 :]
                self.marks[-1] = replace(mark, dose_usv=0.0, seconds=0.0)
                return
        self.marks.append(Mark(east_m=place[0], north_m=place[1], limit_mps=limit_mps))

    def measure(self, dose_usv: float) -> None:
        """Add a dose that was taken in motion since the last mark."""
        last = self.marks[-1]
        self.marks[-1] = replace(last, dose_usv=last.dose_usv + dose_usv)
