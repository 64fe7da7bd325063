# SPDX-License-Identifier: Apache-2.0
"""What stands on a map: readings, photographs, sources, edges of zones, tracks."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rocsafe_view import formats
from rocsafe_view.svg import Point, Rings


@dataclass(frozen=True, slots=True)
class DosePoint:
    """A reading of a dose rate.

    Attributes
    ----------
    x, y
        Map coordinates, metres.
    time_s
        Seconds since the first take-off.
    dose_rate_usvh
        Microsievert per hour.
    vehicle
        Name of the vehicle.
    """

    x: float
    y: float
    time_s: float
    dose_rate_usvh: float
    vehicle: str


@dataclass(frozen=True, slots=True)
class PhotoPoint:
    """Place of a photograph, and the corners of the ground that it shows, if known."""

    x: float
    y: float
    time_s: float
    shot_id: str
    vehicle: str
    viewpoint_id: int
    footprint: tuple[Point, ...]


@dataclass(frozen=True, slots=True)
class SourcePoint:
    """A true source or release of the scenario."""

    x: float
    y: float
    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatePoint:
    """An estimated source with the half axes of its 95 % ellipse and the angle from east."""

    x: float
    y: float
    half_axes_m: tuple[float, float]
    angle_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Cordon:
    """Edge of the ground above a dose rate; each of its parts is a ring and its holes."""

    level_usvh: float
    name: str
    parts: tuple[Rings, ...]

    @property
    def rings(self) -> Rings:
        """Rings of all parts."""
        return tuple(ring for part in self.parts for ring in part)

    @property
    def radius_text(self) -> str:
        """Distance from the middle to the furthest point, of the largest part."""
        text = _metres(max(_radius_m(part[0]) for part in self.parts))
        return text if len(self.parts) == 1 else f'{text} ({len(self.parts)} parts)'

    def labels(self, least_m: float) -> list[tuple[Point, str]]:
        """Return a text and its place, the northernmost point, for parts of at least a radius."""
        level = formats.spaced(formats.dose_rate(self.level_usvh))
        return [
            (min(part[0], key=lambda point: point[1]), f'{level} within {_metres(radius_m)}')
            for part in self.parts
            if (radius_m := _radius_m(part[0])) >= least_m
        ]


@dataclass(frozen=True, slots=True, kw_only=True)
class GasZone:
    """Ground where a response level of gas is exceeded.

    Attributes
    ----------
    level
        Name of the level, for instance AEGL-2.
    number
        1 (discomfort) to 3 (danger of death).
    agent
        The gas.
    ppm, minutes
        Concentration and averaging time of the level.
    expected
        Where it is expected to be exceeded.
    outer
        Where it may be exceeded: the outer bound of 95 %.
    is_cut
        Whether the outer bound is not whole, because the map of the gas ends there.
    reach_m, reach_deg
        Distance of its furthest point from the release nearest to that, and the direction there,
        clockwise from north.
    """

    level: str
    number: int
    agent: str
    ppm: float
    minutes: float
    expected: Rings
    outer: Rings
    is_cut: bool
    reach_m: float
    reach_deg: float

    @property
    def reach_text(self) -> str:
        """How far it reaches and where to."""
        least = 'at least ' if self.is_cut else ''
        return f'{least}{_metres(self.reach_m)} to the {formats.compass(self.reach_deg)}'

    @property
    def name(self) -> str:
        """The level in words."""
        return f'{self.agent}, {self.level}: {self.ppm:g} ppm over {self.minutes:g} minutes'


@dataclass(frozen=True, slots=True, kw_only=True)
class ReleasePoint:
    """An estimated release of gas, with the radius of a circle as large as its region of 95 %."""

    x: float
    y: float
    radius_m: float


def _radius_m(ring: Sequence[Point]) -> float:
    xs, ys = zip(*ring, strict=True)
    x, y = (min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0
    return max(math.hypot(point[0] - x, point[1] - y) for point in ring)


def _metres(value: float) -> str:
    return f'{formats.about(value)}{formats.GAP}m'


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplayTrack:
    """Positions of a vehicle over time, all three of the same length."""

    time_s: Sequence[float]
    x: Sequence[float]
    y: Sequence[float]


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundPicture:
    """A picture of the ground.

    Attributes
    ----------
    data_uri
        The picture, transparent where there is no map.
    width_px, height_px
        Size of the picture.
    matrix
        (a, b, c, d, e, f) of SVG: pixel to map coordinates.
    """

    data_uri: str
    width_px: int
    height_px: int
    matrix: tuple[float, float, float, float, float, float]
