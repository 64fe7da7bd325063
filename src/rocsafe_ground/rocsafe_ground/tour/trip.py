# SPDX-License-Identifier: Apache-2.0
"""A round trip: the points to visit, its budgets, and the result."""

import math
from dataclasses import dataclass

from rocsafe_geo.limits import require_not_negative, require_positive
from rocsafe_ground.route.edges import GridPath

# No limit of time.
AMPLE_S = 1e12


@dataclass(frozen=True, slots=True, kw_only=True)
class TourPoint:
    """A point to visit: its cell, what standing there costs, weight against others."""

    cell: int
    dwell_s: float = 0.0
    dwell_usv: float = 0.0
    dwell_load: float = 0.0
    priority: float = 1.0

    def __post_init__(self) -> None:
        require_not_negative('dwell_s', self.dwell_s, 's')
        require_not_negative('dwell_usv', self.dwell_usv, 'uSv')
        require_not_negative('dwell_load', self.dwell_load)
        require_positive('priority', self.priority)

    @property
    def dwell(self) -> tuple[float, float, float]:
        """Time, dose and toxic load of standing there."""
        return self.dwell_s, self.dwell_usv, self.dwell_load


@dataclass(frozen=True, slots=True, kw_only=True)
class Budgets:
    """Limits of a trip: dose, uSv; time, s; toxic load over that of a level of the gas."""

    dose_usv: float
    time_s: float = AMPLE_S
    load: float = math.inf

    def __post_init__(self) -> None:
        for name, unit in (('dose_usv', 'uSv'), ('load', '')):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f'{name} is {getattr(self, name):g} {unit}: must be 0 or above')
        require_positive('time_s', self.time_s, 's')

    @property
    def limits(self) -> tuple[float, float, float]:
        """Of time, dose and toxic load."""
        return self.time_s, self.dose_usv, self.load


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tour:
    """A round trip.

    Attributes
    ----------
    order
        Numbers of the points visited, from 0.
    legs
        Ways: start to first point, and so on, and back to the start.
    time_s, dose_usv, load
        With dwells.
    bound_s
        No trip on this grid through these points within the budgets takes less.
    price_s_per_usv
        Seconds that one more microsievert saves, about.
    left_out
        Points that do not fit.
    """

    order: tuple[int, ...]
    legs: tuple[GridPath, ...]
    time_s: float
    dose_usv: float
    load: float
    bound_s: float
    price_s_per_usv: float
    left_out: tuple[int, ...]

    @property
    def chosen(self) -> int:
        """The points visited as a set: bit k is point k."""
        return sum(1 << k for k in self.order)

    @property
    def gap_fraction(self) -> float:
        """Upper bound of the relative excess of the time of the trip over the optimum."""
        return max(0.0, 1.0 - self.bound_s / self.time_s) if self.time_s > 0.0 else 0.0
