# SPDX-License-Identifier: Apache-2.0
"""Concentrations of puffs that follow the history of the wind."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.plume.carriers import Carriers, Parcels
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import Travel, at_rows, vertical_shape
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.wind_field import WindField

# Pairs of place and puff that are worked on at once.
_BLOCK = 2_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Puffs:
    """Round clouds at one time.

    Attributes
    ----------
    middles_m : (n, 3)
        East, north and height above the ground of each, metres.
    sigma_m : (n, 2)
        Horizontal and vertical standard deviation, metres.
    masses_g : (n,)
        Mass, g.
    """

    middles_m: FloatArray
    sigma_m: FloatArray
    masses_g: FloatArray

    def concentrations_g_m3(self, places_m: FloatArray) -> FloatArray:
        """Return the concentrations at places (n, 3), heights above the ground, (n,), g/m^3."""
        found = np.zeros(len(places_m))
        size = max(_BLOCK // max(len(self.masses_g), 1), 1)
        for start in range(0, len(places_m), size):
            block = places_m[start : start + size]
            flat = block[:, None, :2] - self.middles_m[:, :2]
            squares = np.einsum('pqk,pqk->pq', flat, flat)
            columns = np.exp(-0.5 * squares / self.sigma_m[:, 0] ** 2) * self._peaks()
            found[start : start + size] = (columns * self._shapes(block[:, 2:])).sum(axis=1)
        return found

    def on_grid_g_m3(self, east_m: FloatArray, north_m: FloatArray, height_m: float) -> FloatArray:
        """Return the concentrations on a level grid, (rows northwards, columns eastwards).

        Round puffs are products of one factor to the east and one to the north, so that the sum
        over all of them is one product of matrices.
        """
        weights = self._peaks() * self._shapes(np.array([[height_m]]))[0]
        east, north = (
            np.exp(-0.5 * ((axis[:, None] - self.middles_m[:, i]) / self.sigma_m[:, 0]) ** 2)
            for i, axis in enumerate((east_m, north_m))
        )
        return np.asarray((north * weights) @ east.T)

    def _peaks(self) -> FloatArray:
        return np.asarray(self.masses_g / (2.0 * math.pi * self.sigma_m[:, 0] ** 2))

    def _shapes(self, heights_m: FloatArray) -> FloatArray:
        """Return the vertical shapes at heights (n, 1), (n, puffs), 1/m."""
        return vertical_shape(heights_m, self.middles_m[:, 2], self.sigma_m[:, 1])


class PuffCloud:
    """The puffs of releases in any wind, at any time; see `Carriers` for restarts."""

    def __init__(
        self,
        releases: Sequence[tuple[Release, Travel]],
        wind: WindField,
        interval_s: float = 2.0,
        longest_s: float = 3600.0,
    ) -> None:
        self._travels = [travel for _, travel in releases]
        self._carriers = [
            Carriers(release, travel, wind, interval_s, longest_s) for release, travel in releases
        ]

    def at(self, time_s: float) -> Puffs:
        """Return the puffs at the last whole interval before `time_s`."""
        each = [
            _puffs(carriers.at(time_s), travel)
            for carriers, travel in zip(self._carriers, self._travels, strict=True)
        ]
        return Puffs(
            middles_m=np.concatenate([np.zeros((0, 3)), *(one.middles_m for one in each)]),
            sigma_m=np.concatenate([np.zeros((0, 2)), *(one.sigma_m for one in each)]),
            masses_g=np.concatenate([np.zeros(0), *(one.masses_g for one in each)]),
        )


def _puffs(parcels: Parcels, travel: Travel) -> Puffs:
    rows = travel.rows(parcels.distances_m)
    return Puffs(
        middles_m=np.column_stack([parcels.places_m, at_rows(travel.heights_m(), rows)]),
        sigma_m=np.column_stack(
            [at_rows(travel.sigma_y_m, rows), at_rows(travel.sigma_z_m, rows)]
        ),
        masses_g=parcels.masses_g,
    )
