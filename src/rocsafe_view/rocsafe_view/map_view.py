# SPDX-License-Identifier: Apache-2.0
"""Content of a map, prepared for the template ``map.html``.

Map coordinates are metres east and south of the origin: those of SVG, north up.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rocsafe_view.map_marks import (
    Cordon,
    DosePoint,
    EstimatePoint,
    GasZone,
    GroundPicture,
    PhotoPoint,
    ReleasePoint,
    ReplayTrack,
    SourcePoint,
)
from rocsafe_view.palette import DoseScale, ramp_colour
from rocsafe_view.svg import Point, Rings, polyline

Box = tuple[float, float, float, float]
COLOUR_STEPS = 32
# Readings further apart in time are not joined: nothing was measured between them.
MOST_GAP_S = 2.5
_MARGIN = 0.06
_LEAST_BOX_M = 20.0


@dataclass(frozen=True, slots=True, kw_only=True)
class MapView:
    """Content of the map; mappings are by name of the vehicle.

    Attributes
    ----------
    origin_deg
        Latitude and longitude of the origin.
    metres_per_degree
        Metres in a degree of latitude and of longitude at the origin.
    planned
        Ground that the planned photographs show.
    viewpoints
        Planned viewpoints, in the order of the route.
    replanned
        Routes of the plans that followed the first.
    readings_per_point
        Each `DosePoint` is the highest of so many readings.
    has_radiation
        Whether there may be dose rates: a mission for gas alone shows nothing of them.
    true_releases
        Releases of the scenario, where they start.
    """

    origin_deg: tuple[float, float]
    metres_per_degree: tuple[float, float]
    vehicles: tuple[str, ...]
    colours: Mapping[str, str]
    region: Rings
    exclusions: Rings
    routes: Mapping[str, tuple[Point, ...]]
    planned: Mapping[str, Rings]
    viewpoints: Mapping[str, tuple[Point, ...]]
    tracks: Mapping[str, tuple[Point, ...]]
    replay: Mapping[str, ReplayTrack]
    readings: tuple[DosePoint, ...]
    readings_per_point: int
    has_radiation: bool
    photos: tuple[PhotoPoint, ...]
    homes: Mapping[str, Point]
    sources: tuple[SourcePoint, ...]
    estimates: tuple[EstimatePoint, ...]
    cordons: tuple[Cordon, ...]
    zones: tuple[GasZone, ...]
    releases: tuple[ReleasePoint, ...]
    true_releases: tuple[SourcePoint, ...]
    replanned: Mapping[str, tuple[tuple[Point, ...], ...]]
    picture: GroundPicture | None

    @property
    def boxes(self) -> dict[str, Box]:
        """Extents to zoom to, by name: the region, and everything that was flown or found."""
        region = [point for ring in self.region for point in ring]
        surveyed = [*region, *(p for line in self.viewpoints.values() for p in line)]
        flown = [*surveyed, *self.homes.values(), *(p for t in self.tracks.values() for p in t)]
        gas = [point for zone in self.zones for ring in zone.outer for point in ring]
        everything = [*flown, *gas] or [(0.0, 0.0)]
        return {'region': _box(surveyed or everything), 'all': _box(everything)}

    @property
    def highest(self) -> int | None:
        """Index of the highest reading, None without readings."""
        rates = [point.dose_rate_usvh for point in self.readings]
        return rates.index(max(rates)) if rates else None

    @property
    def replay_end_s(self) -> int:
        """Time at which the replay ends, whole seconds."""
        return round(max(track.time_s[-1] for track in self.replay.values()))

    def dose_rates_over_region(self) -> list[float]:
        """Return the dose rates measured over the region, all of them if none was."""
        west, north, width, height = self.boxes['region']
        inside = [
            point.dose_rate_usvh
            for point in self.readings
            if west <= point.x <= west + width and north <= point.y <= north + height
        ]
        return inside or [point.dose_rate_usvh for point in self.readings]

    def reading_strokes(self, scale: DoseScale) -> list[tuple[str, str]]:
        """Return the readings along the tracks as path data and colour, a path for each colour."""
        strokes: dict[int, list[str]] = {}
        for step, line in _coloured_lines(self.readings, scale):
            strokes.setdefault(step, []).append(polyline(line))
        return [
            (''.join(strokes[step]), ramp_colour(step / (COLOUR_STEPS - 1)))
            for step in sorted(strokes)
        ]

    def has_source_south_of(self, point: DosePoint) -> bool:
        """Return whether the true source nearest to `point` lies south of it."""
        nearest = min(
            self.sources, key=lambda s: math.hypot(s.x - point.x, s.y - point.y), default=None
        )
        return nearest is not None and point.y < nearest.y

    def script_data(self) -> dict[str, Any]:
        """Return what the script of the page reads, fit for JSON."""
        order = list(self.vehicles)
        return {
            'vehicles': order,
            'colours': [self.colours[name] for name in order],
            'origin': self.origin_deg,
            'perDegree': self.metres_per_degree,
            'boxes': {name: [round(v, 2) for v in box] for name, box in self.boxes.items()},
            'readings': {
                'x': [round(point.x, 1) for point in self.readings],
                'y': [round(point.y, 1) for point in self.readings],
                't': [round(point.time_s, 1) for point in self.readings],
                'd': [float(f'{point.dose_rate_usvh:.4g}') for point in self.readings],
                'v': [order.index(point.vehicle) for point in self.readings],
            },
            'tracks': {
                name: {axis: [round(float(value), 1) for value in values]
                       for axis, values in (('t', track.time_s), ('x', track.x), ('y', track.y))}
                for name, track in self.replay.items()
            },
            'highest': self.highest,
            'photos': {
                photo.shot_id: [
                    round(photo.x, 1), round(photo.y, 1), round(photo.time_s, 1),
                    order.index(photo.vehicle), photo.viewpoint_id,
                    ' '.join(f'{x:.1f},{y:.1f}' for x, y in photo.footprint),
                ]
                for photo in self.photos
            },
        }  # fmt: skip


def _box(places: Iterable[Point]) -> Box:
    xs, ys = zip(*places, strict=True)
    width = max(max(xs) - min(xs), _LEAST_BOX_M)
    height = max(max(ys) - min(ys), _LEAST_BOX_M)
    margin = _MARGIN * max(width, height)
    return min(xs) - margin, min(ys) - margin, width + 2 * margin, height + 2 * margin


def _coloured_lines(
    points: Sequence[DosePoint], scale: DoseScale
) -> Iterator[tuple[int, list[Point]]]:
    """Yield lines of one colour: each reading reaches half-way to its neighbours in time."""
    line: list[Point] = []
    step = -1
    neighbours = zip((None, *points), points, (*points[1:], None), strict=False)
    for before, point, after in neighbours:
        own = round(scale.fraction(point.dose_rate_usvh) * (COLOUR_STEPS - 1))
        start = _middle(before, point)
        if own != step or start is None:
            if line:
                yield step, line
            line, step = [start or (point.x, point.y)], own
        line.append((point.x, point.y))
        end = _middle(point, after)
        if end is not None:
            line.append(end)
    if line:
        yield step, line


def _middle(a: DosePoint | None, b: DosePoint | None) -> Point | None:
    """Return the middle between two readings that belong together, else None."""
    if a is None or b is None or a.vehicle != b.vehicle or b.time_s - a.time_s > MOST_GAP_S:
        return None
    return (a.x + b.x) / 2.0, (a.y + b.y) / 2.0
