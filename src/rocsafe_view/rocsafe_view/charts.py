# SPDX-License-Identifier: Apache-2.0
"""Charts over time, ready to be drawn by the template ``charts.html``, in pixels.

Letters of a chart that is scaled down cannot be read, so each chart has a wide and a narrow form
(`time_axes`), and the style sheet shows the one that fits.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from rocsafe_view.map_marks import DosePoint
from rocsafe_view.palette import DoseScale
from rocsafe_view.svg import number

DOSE_TOP, DOSE_BOTTOM = 10.0, 214.0
_TICK_STEPS_S = (10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14_400)
# Points of one line on a chart; more are not seen.
_MOST_POINTS = 500
_DASHES = ('', '7 3', '2 3', '9 3 2 3')


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightBar:
    """When a vehicle flew, and how long it was planned to; seconds since the first take-off.

    Attributes
    ----------
    start_s, end_s
        Its first take-off and its last touch-down.
    planned_s
        Time planned between them; None if nothing was.
    aloft_s
        Begin and end of each time in the air.
    shots_s
        Times of its photographs.
    """

    vehicle: str
    start_s: float
    end_s: float
    planned_s: float | None
    aloft_s: tuple[tuple[float, float], ...]
    shots_s: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class TimeAxis:
    """The time axis of a chart: pixels from the left, and the time at its end."""

    width: int
    left: int
    end_s: float

    @property
    def right(self) -> int:
        """Pixels of the end of the axis."""
        return self.width - 14

    def x(self, seconds: float) -> float:
        """Return the pixel of a time."""
        span = max(self.end_s, 1.0)
        return self.left + (self.right - self.left) * seconds / span

    def ticks(self) -> list[float]:
        """Return round times, one about every 80 pixels."""
        wanted = self.end_s * 80.0 / max(self.right - self.left, 1)
        step = next((s for s in _TICK_STEPS_S if s >= wanted), _TICK_STEPS_S[-1])
        return [float(step * k) for k in range(int(self.end_s // step) + 1)]


def time_axes(flights: Iterable[FlightBar]) -> dict[str, TimeAxis]:
    """Return a wide and a narrow axis over all `flights`, by the class of the style sheet."""
    end_s = max(max(f.end_s, f.start_s + (f.planned_s or 0.0)) for f in flights)
    return {
        'wide': TimeAxis(width=1080, left=70, end_s=end_s),
        'narrow': TimeAxis(width=380, left=46, end_s=end_s),
    }


def dashes(place: int) -> str:
    """Return the dash pattern that tells the line of the vehicle at `place` from others."""
    return _DASHES[place % len(_DASHES)]


def dose_y(scale: DoseScale, dose_rate_usvh: float) -> float:
    """Return the pixel of a dose rate."""
    return DOSE_BOTTOM - (DOSE_BOTTOM - DOSE_TOP) * scale.fraction(dose_rate_usvh)


def dose_lines(
    points: Sequence[DosePoint], scale: DoseScale, vehicles: Iterable[str], axis: TimeAxis
) -> Mapping[str, str]:
    """Return path data of the dose rate by vehicle, until the end of the axis."""
    points = [point for point in points if point.time_s <= axis.end_s]
    return {
        name: _path(
            (axis.x(point.time_s), dose_y(scale, point.dose_rate_usvh))
            for point in _envelope([point for point in points if point.vehicle == name])
        )
        for name in vehicles
    }


def _envelope(points: Sequence[DosePoint]) -> list[DosePoint]:
    """Return lowest and highest of groups of points, so that no peak is lost."""
    size = -(-len(points) // (_MOST_POINTS // 2))
    if size <= 2:
        return list(points)
    kept = []
    for first in range(0, len(points), size):
        group = points[first : first + size]
        ends = {min(group, key=_rate), max(group, key=_rate)}
        kept += sorted(ends, key=lambda point: point.time_s)
    return kept


def _rate(point: DosePoint) -> float:
    return point.dose_rate_usvh if math.isfinite(point.dose_rate_usvh) else 0.0


def _path(places: Iterable[tuple[float, float]]) -> str:
    steps = [f'{number(x, 1)} {number(y, 1)}' for x, y in places]
    return 'M' + 'L'.join(steps) if steps else ''
