# SPDX-License-Identifier: Apache-2.0
"""Charts over the time since the first take-off, as SVG in pixels: one wide, one for phones.

A chart scaled down has letters that nobody can read, so each is drawn twice and the style sheet
shows the one that fits.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rocsafe_orchestrator.report import formats
from rocsafe_orchestrator.report.map_data import DosePoint, PhotoPoint
from rocsafe_orchestrator.report.markup import Markup, element, number
from rocsafe_orchestrator.report.palette import DoseScale

_CHART_HEIGHT = 240
_ROW_HEIGHT = 26
_TICK_STEPS_S = (10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14_400)
# Points of one line on a chart; more are not seen.
_MOST_POINTS = 500
_DASHES = ('', '7 3', '2 3', '9 3 2 3')


@dataclass(frozen=True, slots=True, kw_only=True)
class Flight:
    """When a vehicle flew, and how long it was planned to; seconds since the first take-off.

    Attributes
    ----------
    start_s, end_s: its first take-off and its last touch-down.
    planned_s: time planned between them; None if nothing was.
    aloft_s: begin and end of each while in the air.
    """

    vehicle: str
    start_s: float
    end_s: float
    planned_s: float | None
    aloft_s: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """Where a chart's time axis lies: pixels from the left, and the time at its end."""

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


def frames(end_s: float) -> dict[str, Frame]:
    """Return the two sizes by the class that the style sheet knows."""
    return {
        'wide': Frame(width=1080, left=70, end_s=end_s),
        'narrow': Frame(width=380, left=46, end_s=end_s),
    }


def dose_chart(
    points: Sequence[DosePoint], scale: DoseScale, colours: Mapping[str, str], frame: Frame
) -> Markup:
    """Return dose rate over time, logarithmic, one line a vehicle."""
    top, bottom = 10.0, _CHART_HEIGHT - 26.0

    def y(dose_rate_usvh: float) -> float:
        return bottom - (bottom - top) * scale.fraction(dose_rate_usvh)

    lines = []
    for place, (name, colour) in enumerate(colours.items()):
        own = [point for point in points if point.vehicle == name]
        path = _line([(frame.x(p.time_s), y(p.dose_rate_usvh)) for p in _envelope(own)])
        lines.append(_series(path, colour, place))
    grid = [
        (
            element('path', class_='grid', d=f'M{frame.left} {number(y(v))}H{frame.right}'),
            element('text', formats.figures(v, 1), class_='axis axis-y', x=frame.left - 8, y=y(v)),
        )
        for v in scale.ticks()
    ]
    return _chart(
        frame,
        _CHART_HEIGHT,
        'Dose rate over time, microsievert per hour, one line for each vehicle',
        [part for row in grid for part in row],
        _time_axis(frame, top, bottom),
        lines,
        element('path', class_='cursor', d=f'M0 {top}V{bottom}'),
    )


def flight_chart(
    flights: Sequence[Flight],
    photos: Sequence[PhotoPoint],
    colours: Mapping[str, str],
    frame: Frame,
) -> Markup:
    """Return a bar for each flight with its photographs, over the planned duration."""
    bottom = 6.0 + _ROW_HEIGHT * max(len(flights), 1)
    rows = []
    for place, flight in enumerate(flights):
        y = 6.0 + _ROW_HEIGHT * place
        shots = ''.join(
            f'M{number(frame.x(photo.time_s))} {number(y + 5)}v12'
            for photo in photos
            if photo.vehicle == flight.vehicle
        )
        rows += [
            element('text', flight.vehicle, class_='axis axis-y', x=frame.left - 8, y=y + 11),
            _planned_bar(flight, frame, y),
            *(
                element(
                    'rect', x=frame.x(start_s), y=y + 5, rx=3, height=12,
                    width=max(frame.x(end_s) - frame.x(start_s), 1.0),
                    fill=colours[flight.vehicle], class_='flight',
                )
                for start_s, end_s in flight.aloft_s
            ),
            element('path', class_='shots', d=shots) if shots else None,
        ]  # fmt: skip
    return _chart(
        frame,
        round(bottom + 26),
        'Flights over time, with a mark for each photograph',
        _time_axis(frame, 6.0, bottom),
        rows,
        element('path', class_='cursor', d=f'M0 6V{number(bottom)}'),
    )


def line_sample(colour: str, place: int) -> Markup:
    """Return a short piece of the line of the vehicle at `place`, for a key."""
    line = _series('M1 6H29', colour, place)
    return element('svg', line, viewBox='0 0 30 12', class_='line-sample', aria_hidden='true')


def _series(path: str, colour: str, place: int) -> Markup:
    """Return a line told apart by its colour and by its dashes."""
    dashes = _DASHES[place % len(_DASHES)] or None
    return element('path', class_='series', d=path, stroke=colour, stroke_dasharray=dashes)


def _planned_bar(flight: Flight, frame: Frame, y: float) -> Markup | None:
    if flight.planned_s is None:
        return None
    width = frame.x(flight.start_s + flight.planned_s) - frame.x(flight.start_s)
    return element(
        'rect', class_='planned', x=frame.x(flight.start_s), y=y + 2, rx=4, height=18, width=width
    )


def _chart(frame: Frame, height: int, text: str, *content: object) -> Markup:
    return element(
        'svg',
        *content,  # type: ignore[arg-type]
        class_='chart',
        viewBox=f'0 0 {frame.width} {height}',
        role='img',
        aria_label=text,
        data_left=frame.left,
        data_right=frame.right,
        data_end=number(frame.end_s),
    )


def _time_axis(frame: Frame, top: float, bottom: float) -> list[Markup]:
    axis = [element('path', class_='axis-line', d=f'M{frame.left} {number(bottom)}H{frame.right}')]
    for seconds in frame.ticks():
        x = frame.x(seconds)
        line = f'M{number(x)} {number(top)}V{number(bottom)}'
        axis.append(element('path', class_='grid grid-x', d=line))
        axis.append(
            element('text', formats.clock(seconds), class_='axis axis-x', x=x, y=bottom + 17)
        )
    return axis


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


def _line(places: Sequence[tuple[float, float]]) -> str:
    return 'M' + 'L'.join(f'{number(x, 1)} {number(y, 1)}' for x, y in places) if places else ''
