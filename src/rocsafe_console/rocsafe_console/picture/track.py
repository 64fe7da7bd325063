# SPDX-License-Identifier: Apache-2.0
"""The flown track of a vehicle, thinned so that its size has a limit."""

import json
import math

MOST_POINTS = 2000
_LEAST_STEP_M = 1.0
_M_PER_DEG = 111_320.0

TrackPoint = tuple[float, float, float]


class Track:
    """Points (latitude, longitude, dose rate) with a least distance, which grows when it is full.

    The dose rate of a point is the highest since the point before: thinning hides no peak.
    """

    def __init__(self) -> None:
        self.points: list[TrackPoint] = []
        self._step_m = _LEAST_STEP_M
        self._highest = math.nan
        self._text, self._told = '', 0

    @property
    def text(self) -> str:
        """The points as a JSON array; each is encoded once, however many pages are opened."""
        new = ','.join(map(_text_of, self.points[self._told :]))
        self._text += f',{new}' if self._text and new else new
        self._told = len(self.points)
        return f'[{self._text}]'

    def note(self, latitude_deg: float, longitude_deg: float, dose_rate_usvh: float) -> None:
        """Add a place unless it is too near to the last one."""
        self._highest = _greater(self._highest, dose_rate_usvh)
        if self.points and self._from_last_m(latitude_deg, longitude_deg) < self._step_m:
            return
        self.points.append((latitude_deg, longitude_deg, self._highest))
        self._highest = math.nan
        if len(self.points) > MOST_POINTS:
            self._thin()

    def _from_last_m(self, latitude_deg: float, longitude_deg: float) -> float:
        latitude, longitude, _ = self.points[-1]
        east = (longitude_deg - longitude) * math.cos(math.radians(latitude))
        return _M_PER_DEG * math.hypot(latitude_deg - latitude, east)

    def _thin(self) -> None:
        """Keep every other point, with the higher dose rate of two."""
        pairs = zip(self.points[::2], self.points[1::2], strict=False)
        kept = [(a[0], a[1], _greater(a[2], b[2])) for a, b in pairs]
        self.points = [*kept, self.points[-1]]
        self._step_m *= 2.0
        self._text, self._told = '', 0


def _text_of(point: TrackPoint) -> str:
    latitude, longitude, rate = point
    shown = None if math.isnan(rate) else rate
    return json.dumps([round(latitude, 7), round(longitude, 7), shown])


def _greater(a: float, b: float) -> float:
    """Return the greater of two numbers; NaN counts as nothing."""
    return b if math.isnan(a) or b > a else a
