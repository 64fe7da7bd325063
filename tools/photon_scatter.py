# SPDX-License-Identifier: Apache-2.0
"""Photons that air and soil scatter to a detector above a point source: a small Monte Carlo.

    python tools/photon_scatter.py --photons 20000 --out scatter.json

Makes ``tables/scatter.json`` of ``rocsafe_radiation``. A source of one energy lies 0.5 m above a
half-space of soil, with air above. Photons are followed from collision to collision; each
collision adds to all detectors what it scatters there (next-event estimator, Lux and Koblinger,
Monte Carlo Particle Transport Methods, 1991, 6.2). Photons scatter from free electrons (Klein and
Nishina). Absorption in air is mu_en less what Compton electrons take; in soil it is 0.75 of the
rest of the attenuation, the share of silicon near 60 keV. Coherent scattering changes nothing.
Soil attenuates as concrete. Fluorescence, bremsstrahlung and pairs are left out.
"""

import argparse
import json
import math
import sys
from pathlib import Path

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_radiation.physics.photons import air_energy_absorption_m2_kg, material

ENERGIES_KEV = (60.0, 140.0, 364.0, 662.0, 1250.0)
HEIGHTS_M = (5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 120.0)
DISTANCES_M = (0.0, 10.0, 20.0, 40.0, 60.0, 90.0, 130.0, 180.0, 250.0)
EDGES_KEV = (20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 700, 1000, 1400)
SOURCE_UP_M = 0.5
ELECTRON_KEV = 510.999
ELECTRON_RADIUS_M = 2.8179403e-15
ELECTRONS_PER_KG = 6.02214e26 * 0.4997
SOIL, AIR = 'concrete', 'air'
ABSORBED_OF_REST_IN_SOIL = 0.75
LEAST_KEV, LEAST_WEIGHT, FARTHEST_M, NEAREST_M = 20.0, 0.02, 2500.0, 0.5
MOST_COLLISIONS, BATCH = 60, 1000


def compton_m2_kg(energies_kev: FloatArray) -> FloatArray:
    """Return the mass attenuation by Compton scattering of free electrons (Klein, Nishina)."""
    a = np.asarray(energies_kev) / ELECTRON_KEV
    log = np.log1p(2.0 * a)
    first = (1.0 + a) / a**2 * (2.0 * (1.0 + a) / (1.0 + 2.0 * a) - log / a)
    second = log / (2.0 * a) - (1.0 + 3.0 * a) / (1.0 + 2.0 * a) ** 2
    return 2.0 * math.pi * ELECTRON_RADIUS_M**2 * (first + second) * ELECTRONS_PER_KG


def scattered_kev(energies_kev: FloatArray, cosines: FloatArray) -> FloatArray:
    """Return the energy after scattering by an angle."""
    return np.asarray(energies_kev / (1.0 + energies_kev / ELECTRON_KEV * (1.0 - cosines)))


def angular_m2_kg(energies_kev: FloatArray, cosines: FloatArray) -> FloatArray:
    """Return the mass attenuation by scattering into one steradian at an angle."""
    share = scattered_kev(energies_kev, cosines) / energies_kev
    form = share**2 * (share + 1.0 / share - 1.0 + cosines**2)
    return np.asarray(0.5 * ELECTRON_RADIUS_M**2 * form * ELECTRONS_PER_KG)


def absorbed_m2_kg(name: str, energies_kev: FloatArray) -> FloatArray:
    """Return the mass attenuation by absorption: no photon is left."""
    known = material(name)
    rest = known.attenuation_per_m(energies_kev) / known.density_kg_m3
    rest = np.maximum(rest - compton_m2_kg(energies_kev), 0.0)
    if name == SOIL:
        return np.asarray(ABSORBED_OF_REST_IN_SOIL * rest)
    left = air_energy_absorption_m2_kg(energies_kev) - _kept_by_electrons(energies_kev)
    return np.clip(left, 0.0, rest)


def _kept_by_electrons(energies_kev: FloatArray) -> FloatArray:
    cosines, weights = np.polynomial.legendre.leggauss(24)
    energies = np.asarray(energies_kev)[..., None]
    lost = 1.0 - scattered_kev(energies, cosines) / energies
    total = (angular_m2_kg(energies, cosines) * lost) @ weights
    return np.asarray(2.0 * math.pi * total)


class Medium:
    """Attenuation of one medium by energy, tabulated."""

    def __init__(self, name: str) -> None:
        self._energies: FloatArray = np.geomspace(LEAST_KEV / 2.0, 3000.0, 400, dtype=np.float64)
        density = material(name).density_kg_m3
        compton = compton_m2_kg(self._energies) * density
        self._total = compton + absorbed_m2_kg(name, self._energies) * density
        self._share = compton / self._total

    def per_m(self, energies_kev: FloatArray) -> FloatArray:
        """Return the attenuation, 1/m."""
        return np.interp(energies_kev, self._energies, self._total)

    def scattered_share(self, energies_kev: FloatArray) -> FloatArray:
        """Return the share of collisions that scatter."""
        return np.interp(energies_kev, self._energies, self._share)


class Simulation:
    """Photons of one energy over soil, or in air without end."""

    def __init__(self, points_m: FloatArray, *, has_soil: bool = True) -> None:
        self._points = points_m
        self._air, self._soil = Medium(AIR), Medium(SOIL if has_soil else AIR)

    def fluences(
        self, energy_kev: float, photons: int, generator: np.random.Generator
    ) -> FloatArray:
        """Return the scattered fluence for one photon, shape (points, bins)."""
        total = np.zeros((len(self._points), len(EDGES_KEV) - 1))
        for start in range(0, photons, BATCH):
            count = min(BATCH, photons - start)
            places = np.tile([0.0, 0.0, SOURCE_UP_M], (count, 1))
            ways = _anywhere(count, generator)
            energies: FloatArray = np.full(count, energy_kev)
            weights: FloatArray = np.ones(count)
            for _ in range(MOST_COLLISIONS):
                places = self._moved(places, ways, energies, generator)
                above = places[:, 2] > 0.0
                shares = np.where(
                    above,
                    self._air.scattered_share(energies),
                    self._soil.scattered_share(energies),
                )
                weights = weights * shares
                keep = (np.abs(places) < FARTHEST_M).all(axis=1)
                roulette = weights < LEAST_WEIGHT
                keep &= ~roulette | (generator.random(len(weights)) < 0.1)
                weights = np.where(roulette, 10.0 * weights, weights)
                places, ways, energies, weights = (
                    part[keep] for part in (places, ways, energies, weights)
                )
                if not len(weights):
                    break
                self._score(total, places, ways, energies, weights)
                ways, energies = _scattered(ways, energies, generator)
                keep = energies > LEAST_KEV
                places, ways, energies, weights = (
                    part[keep] for part in (places, ways, energies, weights)
                )
        return total / photons

    def _moved(
        self,
        places: FloatArray,
        ways: FloatArray,
        energies: FloatArray,
        generator: np.random.Generator,
    ) -> FloatArray:
        """Return the places of the next collisions."""
        depths = generator.exponential(size=len(places))
        air, soil = self._air.per_m(energies), self._soil.per_m(energies)
        above = places[:, 2] > 0.0
        here, there = np.where(above, air, soil), np.where(above, soil, air)
        with np.errstate(divide='ignore'):
            reach = -places[:, 2] / ways[:, 2]
        reach = np.where(reach > 0.0, reach, np.inf)
        inside = depths <= here * reach
        beyond = np.where(inside, 0.0, depths - np.where(inside, 0.0, here * reach)) / there
        lengths = np.where(inside, depths / here, np.where(inside, 0.0, reach) + beyond)
        return np.asarray(places + np.minimum(lengths, 2.0 * FARTHEST_M)[:, None] * ways)

    def _score(
        self,
        total: FloatArray,
        places: FloatArray,
        ways: FloatArray,
        energies: FloatArray,
        weights: FloatArray,
    ) -> None:
        rays = self._points[None] - places[:, None]
        distances = np.maximum(np.linalg.norm(rays, axis=2), NEAREST_M)
        cosines = np.clip(np.einsum('npc,nc->np', rays, ways) / distances, -1.0, 1.0)
        own = energies[:, None]
        after = scattered_kev(own, cosines)
        densities = angular_m2_kg(own, cosines) / compton_m2_kg(own)
        # The part of each ray below the surface; detectors are above it.
        rise = self._points[None, :, 2] - places[:, 2][:, None]
        below = np.where(places[:, 2][:, None] < 0.0, -places[:, 2][:, None] / rise, 0.0)
        depths = distances * (
            below * self._soil.per_m(after) + (1.0 - below) * self._air.per_m(after)
        )
        scores = weights[:, None] * densities * np.exp(-depths) / distances**2
        bins = np.searchsorted(EDGES_KEV, after) - 1
        kept = bins >= 0
        bins = np.minimum(bins, total.shape[1] - 1)
        flat = np.arange(total.shape[0])[None] * total.shape[1] + bins
        total += np.bincount(flat[kept], scores[kept], total.size).reshape(total.shape)


def _anywhere(count: int, generator: np.random.Generator) -> FloatArray:
    ways = generator.normal(size=(count, 3))
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))


def _scattered(
    ways: FloatArray, energies: FloatArray, generator: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return directions and energies after a collision, drawn by rejection."""
    cosines = np.empty(len(ways))
    left: IndexArray = np.arange(len(ways))
    while left.size:
        tried = generator.uniform(-1.0, 1.0, left.size)
        own = energies[left]
        limit = angular_m2_kg(own, np.ones(left.size)) * generator.random(left.size)
        taken = angular_m2_kg(own, tried) > limit
        cosines[left[taken]] = tried[taken]
        left = left[~taken]
    axes = np.where(np.abs(ways[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(ways, axes)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(ways, first)
    turns = generator.uniform(0.0, 2.0 * math.pi, len(ways))
    sines = np.sqrt(np.maximum(1.0 - cosines**2, 0.0))
    across = np.cos(turns)[:, None] * first + np.sin(turns)[:, None] * second
    turned = cosines[:, None] * ways + sines[:, None] * across
    turned /= np.linalg.norm(turned, axis=1, keepdims=True)
    return turned, scattered_kev(energies, cosines)


def table(photons: int) -> dict[str, object]:
    """Return the table: scattered fluence in bins over that of the source without any matter."""
    points = np.array([[r, 0.0, h] for h in HEIGHTS_M for r in DISTANCES_M])
    squares = ((points - [0.0, 0.0, SOURCE_UP_M]) ** 2).sum(axis=1)
    simulation = Simulation(points)
    shares = []
    for number, energy in enumerate(ENERGIES_KEV):
        generator = np.random.default_rng([number, 0x5CA7])
        fluences = simulation.fluences(energy, photons, generator)
        shares.append(fluences * 4.0 * math.pi * squares[:, None])
    shape = (len(ENERGIES_KEV), len(HEIGHTS_M), len(DISTANCES_M), len(EDGES_KEV) - 1)
    rounded = [float(f'{value:.4g}') for value in np.ravel(shares)]
    return {
        'made_by': f'tools/photon_scatter.py --photons {photons}',
        'energies_kev': ENERGIES_KEV,
        'heights_m': HEIGHTS_M,
        'distances_m': DISTANCES_M,
        'edges_kev': EDGES_KEV,
        'shares': np.reshape(rounded, shape).tolist(),
    }


def main() -> int:
    """Write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--photons', type=int, default=20_000)
    parser.add_argument('--out', type=Path, required=True)
    options = parser.parse_args()
    options.out.write_text(json.dumps(table(options.photons)) + '\n', encoding='utf-8')
    sys.stdout.write(f'{options.out}\n')
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
