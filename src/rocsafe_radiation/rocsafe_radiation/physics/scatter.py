# SPDX-License-Identifier: Apache-2.0
"""What a detector counts of a source on the ground: photons scattered by air and soil, too.

A detector without an energy window counts scattered photons, of which there are many more for a
dose than of those of the source. Their fluences are tabulated by height and distance in
``tables/scatter.json``, made by ``tools/photon_scatter.py``.
"""

import json
import math
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_radiation.physics.nuclide import nuclide
from rocsafe_radiation.physics.photons import (
    AIR,
    air_energy_absorption_m2_kg,
    dose_per_kerma_sv_gy,
    material,
)
from rocsafe_radiation.physics.transmission import air_transmission

# Energies in keV, ascending, and counts for a dose relative to those for Cs-137.
Response = tuple[tuple[float, float], ...]
REFERENCE_NUCLIDE = 'Cs-137'
# Steps of distance of tables of counts: counts for a dose change by less than 1 % in one.
STEP_M = 1.0
# Distances at a time: their arrays stay in the cache of a core.
BLOCK = 16384


def mean_response(nuclide_name: str, response: Response) -> float:
    """Return counts for the dose of the unscattered lines of a nuclide."""
    source = nuclide(nuclide_name)
    return float(source.dose_shares() @ _at(response, source.energies_kev))


def counts_for_dose(
    nuclide_name: str, response: Response, heights_m: FloatArray, distances_m: FloatArray
) -> FloatArray:
    """Return counts over those of a beam of Cs-137 with the dose rate that the law ``air`` states.

    Parameters
    ----------
    nuclide_name
        Of the source, on the ground.
    response
        Of the detector.
    heights_m, distances_m : shape (n,)
        Of the detector above the source, and from it. Outside of the table (5 to 120 m high, 250 m
        away), the values are those of its rim.
    """
    grid = _grid(nuclide_name, response)
    along = np.sqrt(np.maximum(distances_m**2 - heights_m**2, 0.0))
    row, low = _cell(np.log(grid.heights_m), np.log(np.maximum(heights_m, 1.0)))
    column, west = _cell(grid.distances_m, along)
    values = grid.values
    near = values[row, column] + west * (values[row, column + 1] - values[row, column])
    far = values[row + 1, column] + west * (values[row + 1, column + 1] - values[row + 1, column])
    return np.asarray(near + low * (far - near))


@dataclass(frozen=True, slots=True, eq=False)
class CountedTable:
    """Counts for a dose at n heights, each by distance in steps of `STEP_M`, linear in between.

    Attributes
    ----------
    values
        Shape (n, steps). The last is that of all farther distances.
    """

    values: FloatArray

    def at(self, distances_m: FloatArray) -> FloatArray:
        """Return counts for a dose at distances, shape (..., n)."""
        rows = np.atleast_2d(distances_m)
        found = np.empty_like(rows)
        size = max(1, BLOCK // rows.shape[1])
        for start in range(0, len(rows), size):
            block = slice(start, start + size)
            found[block] = self.at_with_slope(rows[block])[0]
        return found.reshape(distances_m.shape)

    def at_with_slope(self, distances_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return counts for a dose at distances, shape (..., n), and their derivatives, 1/m."""
        steps = self.values.shape[1]
        places = np.minimum(distances_m * (1.0 / STEP_M), steps - 1.001)
        indices = places.astype(np.intp)
        places -= indices
        indices += steps * np.arange(len(self.values))
        flat = self.values.ravel()
        values = flat[indices]
        indices += 1
        rises = flat[indices] - values
        return values + places * rises, rises * (1.0 / STEP_M)


def counted_table(nuclide_name: str, response: Response, heights_m: FloatArray) -> CountedTable:
    """Return counts for a dose by distance at heights above the source, shape (n,)."""
    farthest_m = math.hypot(_table()['distances_m'][-1], _table()['heights_m'][-1])
    distances = np.arange(0.0, farthest_m + 2.0 * STEP_M, STEP_M, dtype=np.float64)
    shape = len(heights_m), len(distances)
    heights, away = np.repeat(heights_m, shape[1]), np.tile(distances, shape[0])
    return CountedTable(counts_for_dose(nuclide_name, response, heights, away).reshape(shape))


@dataclass(frozen=True, slots=True)
class _Grid:
    """Counts for a dose at heights and horizontal distances, shape (heights, distances)."""

    heights_m: FloatArray
    distances_m: FloatArray
    values: FloatArray


def _cell(nodes: FloatArray, places: FloatArray) -> tuple[IndexArray, FloatArray]:
    """Return the node below each place and the fraction of the way to the next."""
    inside = np.clip(places, nodes[0], nodes[-1])
    index = np.clip(np.searchsorted(nodes, inside) - 1, 0, len(nodes) - 2)
    return index, (inside - nodes[index]) / (nodes[index + 1] - nodes[index])


@cache
def _grid(nuclide_name: str, response: Response) -> _Grid:
    table = _table()
    heights, distances = np.array(table['heights_m']), np.array(table['distances_m'])
    slants = np.hypot(*np.meshgrid(heights, distances, indexing='ij'))
    edges = np.array(table['edges_kev'])
    middles = np.sqrt(edges[1:] * edges[:-1])
    # Counts for one photon of the source, at the energies of the table.
    scattered = np.array(table['shares']) @ (_dose(middles) * _at(response, middles))
    source = nuclide(nuclide_name)
    shares = source.dose_shares()
    total = np.zeros(slants.shape)
    for energy, share in zip(source.energies_kev[shares > 0.0], shares[shares > 0.0], strict=True):
        own = np.array([energy])
        per_m = float(material(AIR).attenuation_per_m(energy))
        direct = np.exp(-per_m * slants) * float(_at(response, own)[0])
        total += share * (direct + _between(table['energies_kev'], scattered, energy) / _dose(own))
    reference = mean_response(REFERENCE_NUCLIDE, response)
    # The source of the table lies on the ground below the heights.
    values = total / reference / air_transmission(nuclide_name, slants)
    return _Grid(heights, distances, _smoothed(_smoothed(values).T).T)


def _smoothed(values: FloatArray) -> FloatArray:
    """Return each row with its neighbours: the table has a noise of some percent."""
    padded = np.pad(values, ((1, 1), (0, 0)), mode='edge')
    return np.asarray(0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:])


def _between(energies_kev: list[float], values: FloatArray, energy_kev: float) -> FloatArray:
    """Return `values` (energies, ...) at an energy, linear in its logarithm."""
    places = np.interp(np.log(energy_kev), np.log(energies_kev), np.arange(len(energies_kev)))
    first = min(int(places), len(energies_kev) - 2)
    share = float(places) - first
    return np.asarray((1.0 - share) * values[first] + share * values[first + 1])


def _dose(energies_kev: FloatArray) -> FloatArray:
    """Return H*(10) for a fluence, in any unit."""
    kerma = energies_kev * air_energy_absorption_m2_kg(energies_kev)
    return np.asarray(kerma * dose_per_kerma_sv_gy(energies_kev))


def _at(response: Response, energies_kev: FloatArray) -> FloatArray:
    energies, values = np.array(response).T
    return np.asarray(np.interp(np.log(energies_kev), np.log(energies), values))


@cache
def _table() -> dict[str, Any]:
    text = resources.files('rocsafe_radiation').joinpath('tables/scatter.json').read_text('utf-8')
    return dict(json.loads(text))
