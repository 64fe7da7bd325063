# SPDX-License-Identifier: Apache-2.0
"""Options of the ground's height: an elevation model, or whoever else knows the ground."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.terrain.terrain import LocalGround, Terrain
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_radiation.field_parameters.field_assembly import places_of
from rocsafe_radiation.field_parameters.provider import provider_of
from rocsafe_radiation.readings.ground import GroundHeights

Places = tuple[GeoPosition, ...]
# File, seed and places of known ground, the mission's origin first -> heights of the ground.
HeightsProvider = Callable[[str, int, Places], GroundHeights]


class TerrainHeights:
    """An elevation model, shifted by one height so that it agrees with places of known ground.

    So it does not matter above what it counts. Without such places it is not shifted.
    """

    def __init__(self, terrain: Terrain, known: Places) -> None:
        self._terrain = terrain
        self._shift_m = (
            LocalGround(terrain, LocalFrame(known[0]), [*known]).shift_m if known else 0.0
        )

    def altitudes_m(self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike) -> FloatArray:
        """Return the altitude of the ground, (n,); NaN where the model has none."""
        return self._terrain.altitudes_m(latitudes_deg, longitudes_deg) + self._shift_m


def heights_of_file(file: str, _seed: int, known: Places) -> GroundHeights:
    """Return the heights of a GeoTIFF.

    Raises
    ------
    ValueError: in one line, if it is none, or has no height at a place of known ground.
    """
    return TerrainHeights(read_terrain(file), known)


# A scene takes seconds to make: options that are checked and then used make it once.
@lru_cache(maxsize=2)
def provided_heights(provider: str, file: str, seed: int, known: Places) -> GroundHeights:
    """Return what `provider`, or else the GeoTIFF `file` itself, says of the ground.

    Raises
    ------
    ValueError: in one line, if it cannot say.
    """
    if not provider:
        return heights_of_file(file, seed, known)
    make: HeightsProvider = provider_of('terrain_provider', provider)
    try:
        return make(file, seed, known)
    except Exception as error:
        raise ValueError(f'terrain_file = {file!r}: {error}') from error


@dataclass(frozen=True, slots=True, kw_only=True)
class TerrainOptions:
    """How high the ground is, where it is not level."""

    terrain_file: str = field(
        default='',
        metadata={'doc': 'GeoTIFF of the heights of the ground; empty: the ground is level'},
    )
    terrain_provider: str = field(
        default='',
        metadata={
            'doc': 'who else reads the file: module:function of the file, the seed and the '
            'places; empty: it is a GeoTIFF'
        },
    )
    terrain_seed: int = field(
        default=0,
        metadata={'doc': 'seed of a ground that is made', 'min': 0, 'max': 2**31 - 1},
    )
    terrain_latitudes_deg: tuple[float, ...] = field(
        default=(),
        metadata={
            'doc': 'WGS84 latitudes of places on the ground of known altitude, degrees: heights '
            'are shifted to agree'
        },
    )
    terrain_longitudes_deg: tuple[float, ...] = field(
        default=(), metadata={'doc': 'WGS84 longitudes of these places, degrees'}
    )
    terrain_altitudes_m: tuple[float, ...] = field(
        default=(), metadata={'doc': 'their altitudes above the ellipsoid, metres'}
    )

    def heights(self) -> GroundHeights | None:
        """Return who knows the height of the ground, None if it is level.

        Raises
        ------
        ValueError: in one line, if a place or the file is wrong.
        """
        lists = (self.terrain_longitudes_deg, self.terrain_altitudes_m)
        for name, values in zip(('longitudes_deg', 'altitudes_m'), lists, strict=True):
            if len(values) != len(self.terrain_latitudes_deg):
                raise ValueError(
                    f'terrain_{name} has {len(values)} values, but terrain_latitudes_deg has '
                    f'{len(self.terrain_latitudes_deg)}'
                )
        if not self.terrain_file:
            return None
        names = [f'terrain place {index}' for index in range(len(self.terrain_latitudes_deg))]
        known = places_of(names, self.terrain_latitudes_deg, *lists)
        return provided_heights(self.terrain_provider, self.terrain_file, self.terrain_seed, known)


def lifted(places: Places, heights: GroundHeights | None, level_m: float) -> Places:
    """Return places over level ground at `level_m` as high above the real ground as over that."""
    if heights is None or not places:
        return places
    altitudes = heights.altitudes_m(
        [place.latitude_deg for place in places], [place.longitude_deg for place in places]
    )
    rises = np.where(np.isfinite(altitudes), altitudes - level_m, 0.0).tolist()
    return tuple(
        replace(place, altitude_m=place.altitude_m + rise)
        for place, rise in zip(places, rises, strict=True)
    )
