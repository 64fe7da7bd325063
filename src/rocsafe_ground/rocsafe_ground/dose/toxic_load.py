# SPDX-License-Identifier: Apache-2.0
"""The gas that a drive goes through: highest concentration and toxic load.

The toxic load is the integral of C^n over time (ten Berge and others 1986), with the published n
of the gas; it is told as a share of that of level 2 (AEGL-2, else ERPG-2) over its averaging time.
The vehicle does not breathe: this is for the people who follow it.
"""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rasterio.enums import Resampling

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.limits import require_between, require_positive
from rocsafe_ground.drivable.raster import read_bands
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.errors import NoMapError

PLUME, ZONES = 'plume.tif', 'threat_zones.geojson'
MEAN, UPPER = 0, 1
LEVEL = '-2'


@dataclass(frozen=True, slots=True, kw_only=True)
class GasExposure:
    """Gas along a drive.

    Attributes
    ----------
    agent, level
        The gas, and the level that loads are shares of, with its averaging time.
    highest_ppm, highest_upper_ppm
        Highest concentration, mean and upper 95 %.
    load_share, load_upper_share
        Toxic load over that of the level, mean and upper 95 %; NaN: n is not known.
    unknown_s
        Time in which the map of the gas does not reach the vehicle; it counts as free of gas.
    """

    agent: str
    level: str
    highest_ppm: float
    highest_upper_ppm: float
    load_share: float
    load_upper_share: float
    unknown_s: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GasField:
    """Concentrations on a grid.

    Attributes
    ----------
    mean_ppm, upper_ppm : (rows, columns)
        Concentration 1.5 m above the ground, mean and upper 95 %; NaN where the map does not
        reach.
    agent, level
        The gas, and the name of its level 2.
    level_ppm, level_minutes
        Concentration and averaging time of the level.
    load_exponent
        n of the toxic load; None: not known.
    """

    mean_ppm: FloatArray
    upper_ppm: FloatArray
    agent: str
    level: str
    level_ppm: float
    level_minutes: float
    load_exponent: float | None

    def __post_init__(self) -> None:
        require_positive('level_ppm', self.level_ppm, 'ppm')
        require_positive('level_minutes', self.level_minutes, 'min')
        if self.load_exponent is not None:
            require_between('load_exponent', self.load_exponent, 0.5, 10.0)

    def exposure(self, cells: IndexArray, seconds: FloatArray) -> GasExposure:
        """Return the gas of the times that a drive spends in cells."""
        mean, upper = self.mean_ppm.ravel()[cells], self.upper_ppm.ravel()[cells]
        is_unknown = np.isnan(mean) | np.isnan(upper)
        mean, upper = np.where(is_unknown, 0.0, mean), np.where(is_unknown, 0.0, upper)
        return GasExposure(
            agent=self.agent,
            level=f'{self.level}, {self.level_minutes:g} min',
            highest_ppm=float(mean.max(initial=0.0)),
            highest_upper_ppm=float(upper.max(initial=0.0)),
            load_share=self._share(mean, seconds),
            load_upper_share=self._share(upper, seconds),
            unknown_s=float(seconds[is_unknown].sum()),
        )

    def loads_per_s(self) -> FloatArray | None:
        """Return the toxic load that a second adds by the upper 95 %, (rows, columns).

        As a share of that of the level; None: n is not known.
        """
        if self.load_exponent is None:
            return None
        ratio = np.nan_to_num(self.upper_ppm) / self.level_ppm
        return np.asarray(ratio**self.load_exponent / (60.0 * self.level_minutes))

    def _share(self, ppm: FloatArray, seconds: FloatArray) -> float:
        if self.load_exponent is None:
            return math.nan
        load = ((ppm / self.level_ppm) ** self.load_exponent * seconds / 60.0).sum()
        return float(load) / self.level_minutes


def read_gas(folder: Path, grid: RouteGrid) -> GasField | None:
    """Return the gas that a survey found; None if it found none.

    Raises
    ------
    NoMapError
        If a file of it cannot be read.
    """
    plume, zones = folder / PLUME, folder / ZONES
    if not (plume.is_file() and zones.is_file()):
        return None
    bands = read_bands(plume)
    if len(bands.values) <= UPPER:
        raise NoMapError(f'{plume}: has {len(bands.values)} bands: must have mean and upper 95 %')
    values = bands.on(grid, Resampling.bilinear)
    try:
        facts = _facts(zones)
        if facts is None:
            return None
        exponent = facts.get('load_exponent')
        return GasField(
            mean_ppm=values[MEAN],
            upper_ppm=values[UPPER],
            agent=str(facts['agent']),
            level=str(facts['level']),
            level_ppm=float(facts['ppm']),
            level_minutes=float(facts['averaging_minutes']),
            load_exponent=None if exponent is None else float(exponent),
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise NoMapError(f'{zones}: cannot be read as threat zones: {error}') from error


def _facts(path: Path) -> dict[str, Any] | None:
    """Return the properties of the zone of level 2, None if there is none."""
    content = json.loads(path.read_text(encoding='utf-8'))
    rows = [dict(feature['properties']) for feature in content['features']]
    return next((row for row in rows if str(row['level']).endswith(LEVEL)), None)
