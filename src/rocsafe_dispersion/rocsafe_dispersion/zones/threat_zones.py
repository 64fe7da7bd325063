# SPDX-License-Identifier: Apache-2.0
"""Ground above a response level: the expected area and the outer bound of 95 %."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import contourpy
import numpy as np
import shapely
from shapely.geometry import MultiPolygon, mapping
from shapely.ops import transform

from rocsafe_dispersion.zones.exposure import MapGrid
from rocsafe_dispersion.zones.levels import ResponseLevel
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_hazard import contours

OUTER_SHARE = 0.95


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ThreatZone:
    """Areas in which one level is exceeded.

    Attributes
    ----------
    level
        The level.
    expected
        Where the mean over wind and source exceeds it, metres east and north.
    outer
        Where it may be exceeded: the concentration that is not exceeded with a probability of
        0.95 is above it.
    is_cut
        Whether the outer bound reaches the edge of the map, and so is not whole.
    """

    level: ResponseLevel
    expected: MultiPolygon
    outer: MultiPolygon
    is_cut: bool

    @property
    def farthest_m(self) -> float:
        """Largest distance of the expected area from the origin of the frame, metres."""
        if self.expected.is_empty:
            return 0.0
        return float(np.hypot(*shapely.get_coordinates(self.expected).T).max())


def threat_zones(
    grid: MapGrid, maps_g_m3: Sequence[FloatArray], levels: Sequence[ResponseLevel]
) -> list[ThreatZone]:
    """Return the zones of levels.

    Parameters
    ----------
    grid
        Points of the maps.
    maps_g_m3
        Concentrations (rows, columns) for each sample of wind and source, averaged over the times
        of the levels; one map: nothing is uncertain.
    levels
        Levels.

    Raises
    ------
    ValueError
        If there is no map, or one of another shape or with values below 0 or not finite.
    """
    if not maps_g_m3:
        raise ValueError('threat zones need at least one map of concentrations')
    for values in maps_g_m3:
        if values.shape != (grid.rows, grid.columns):
            raise ValueError(f'map of shape {values.shape} must be {(grid.rows, grid.columns)}')
        if not (np.isfinite(values).all() and (values >= 0.0).all()):
            raise ValueError('concentrations of a map must be finite and not below 0')
    mean = np.mean(maps_g_m3, axis=0)
    outer = np.maximum(np.quantile(maps_g_m3, OUTER_SHARE, axis=0, method='higher'), mean)
    return [
        ThreatZone(
            level=level,
            expected=area_above(grid, mean, level.g_m3),
            outer=area_above(grid, outer, level.g_m3),
            is_cut=_reaches_edge(outer, level.g_m3),
        )
        for level in levels
    ]


def area_above(grid: MapGrid, values: FloatArray, level: float) -> MultiPolygon:
    """Return where `values` (rows, columns) exceed a level, metres east and north.

    Between points the logarithm is linear, as concentrations fall by orders of magnitude from
    one point to the next.
    """
    floor = level * 1e-6
    logs = np.log(np.maximum(values, floor))
    return contours.area_above(grid.east_m(), grid.north_m(), logs, float(np.log(level)))


def lines_at(grid: MapGrid, values: FloatArray, level: float) -> list[FloatArray]:
    """Return where finite `values` (rows, columns) equal a level: lines of (n, 2), metres.

    The edge of ground without a value is no such line.
    """
    # Takes points without a finite value for masked.
    lines = contourpy.contour_generator(grid.east_m(), grid.north_m(), values, name='serial')
    return [np.asarray(line) for line in lines.lines(level)]


def _reaches_edge(values: FloatArray, level: float) -> bool:
    edges = (values[0], values[-1], values[:, 0], values[:, -1])
    return any(bool((edge >= level).any()) for edge in edges)


def zones_geojson(
    zones: Sequence[ThreatZone], frame: LocalFrame, properties: Mapping[str, object]
) -> dict[str, object]:
    """Return zones as a GeoJSON feature collection in WGS84 (RFC 7946).

    Parameters
    ----------
    zones
        Zones in the frame's metres.
    frame
        The frame.
    properties
        What all features tell, for instance the agent and the method.
    """
    features = []
    for zone in zones:
        for kind, area in (('expected', zone.expected), ('outer bound 95 %', zone.outer)):
            own = {
                'level': zone.level.name,
                'averaging_minutes': zone.level.minutes,
                'ppm': zone.level.ppm,
                'kind': kind,
                'is_cut_by_the_map': zone.is_cut,
            }
            geometry = mapping(transform(_to_lonlat(frame), area))
            features.append(
                {'type': 'Feature', 'properties': own | dict(properties), 'geometry': geometry}
            )
    return {'type': 'FeatureCollection', 'features': features}


def _to_lonlat(frame: LocalFrame) -> Callable[..., tuple[FloatArray, FloatArray]]:
    def convert(east: Any, north: Any, *_: Any) -> tuple[FloatArray, FloatArray]:
        east, north = np.atleast_1d(east), np.atleast_1d(north)
        geodetic = frame.to_geodetic(np.column_stack([east, north, np.zeros(len(east))]))
        return geodetic[:, 1], geodetic[:, 0]

    return convert
