# SPDX-License-Identifier: Apache-2.0
"""Maps of a plume and its threat zones, from samples of releases."""

import cmath
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_dispersion.agents.agent_table import Agent
from rocsafe_dispersion.estimation.found_release import ReleaseSamples
from rocsafe_dispersion.estimation.measuring_places import MeanAir, predicted
from rocsafe_dispersion.estimation.release_options import SearchArea
from rocsafe_dispersion.zones.exposure import MapGrid
from rocsafe_dispersion.zones.levels import response_levels
from rocsafe_dispersion.zones.threat_zones import OUTER_SHARE, ThreatZone, threat_zones
from rocsafe_geo.arrays import FloatArray

# Points of a map along its longer side, and how far it reaches downwind of the area, metres.
POINTS_ACROSS = 100
REACH_M = 1000.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlumeMap:
    """Concentrations where people breathe, and where they exceed response levels.

    Attributes
    ----------
    grid
        Points.
    mean_g_m3, upper_g_m3 : (rows, columns)
        Mean over wind and source, and what is not exceeded with a probability of 0.95, g/m^3.
    arrival_s : (rows, columns)
        Time from the release to here with the mean wind, seconds; infinite: not downwind.
    zones
        Threat zones.
    """

    grid: MapGrid
    mean_g_m3: FloatArray
    upper_g_m3: FloatArray
    arrival_s: FloatArray
    zones: tuple[ThreatZone, ...]


def plume_map(
    groups: Sequence[ReleaseSamples], area: SearchArea, air: MeanAir, agent: Agent
) -> PlumeMap:
    """Return the map of releases, each with equally many samples, at least one.

    Levels hold for 60 minutes of exposure and a plume that has become steady.
    """
    # The wind that the releases fit.
    fitting = replace(air, towards_mps=_turned(air.towards_mps, groups[0].shapes.mean_turn_rad))
    grid = _grid(area, fitting)
    places = grid.places_m()
    totals = predicted(groups[0], places, air)
    for samples in groups[1:]:
        totals = totals + predicted(samples, places, air)
    maps = totals.reshape(-1, grid.rows, grid.columns)
    middle = np.mean([samples.places_m.mean(axis=0) for samples in groups], axis=0)
    mean = maps.mean(axis=0)
    upper = np.quantile(maps, OUTER_SHARE, axis=0, method='higher')
    return PlumeMap(
        grid=grid,
        mean_g_m3=mean,
        upper_g_m3=np.maximum(upper, mean),
        arrival_s=_arrival(places, middle, fitting).reshape(mean.shape),
        zones=tuple(threat_zones(grid, list(maps), response_levels(agent))),
    )


def _turned(towards_mps: tuple[float, float], turn_rad: float) -> tuple[float, float]:
    found = complex(*towards_mps) * cmath.rect(1.0, turn_rad)
    return found.real, found.imag


def _grid(area: SearchArea, air: MeanAir) -> MapGrid:
    """Return points over the area and downwind of it."""
    east, north = np.array(air.towards_mps) / np.hypot(*air.towards_mps) * REACH_M
    west_m, east_m = min(area.west_m, area.west_m + east), max(area.east_m, area.east_m + east)
    south_m = min(area.south_m, area.south_m + north)
    north_m = max(area.north_m, area.north_m + north)
    cell_m = max(east_m - west_m, north_m - south_m) / POINTS_ACROSS
    return MapGrid(
        west_m=float(west_m),
        south_m=float(south_m),
        cell_m=float(cell_m),
        columns=max(int((east_m - west_m) / cell_m), 1) + 1,
        rows=max(int((north_m - south_m) / cell_m), 1) + 1,
    )


def _arrival(places_m: FloatArray, source_m: FloatArray, air: MeanAir) -> FloatArray:
    """Return the time that the middle of a plume takes along the wind, (n,), seconds."""
    speed = float(np.hypot(*air.towards_mps))
    along = (places_m[:, :2] - source_m) @ (np.array(air.towards_mps) / speed)
    within = np.minimum(np.maximum(along, 0.0), float(air.travel.distances_m[-1]))
    return np.where(along > 0.0, np.interp(within, air.travel.distances_m, air.travel.times_s),
                    np.inf)  # fmt: skip
