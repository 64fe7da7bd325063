# SPDX-License-Identifier: Apache-2.0
"""Share of the dose rate of a source that air and other materials transmit."""

from collections.abc import Mapping
from functools import cache

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.physics.nuclide import nuclide
from rocsafe_radiation.physics.photons import AIR, geometric_progression, material

# Linear interpolation between steps is good to 1e-5 at 60 keV and better above.
STEP_M = 0.25
# Beyond this, air transmits less than 1e-8 of any line.
REACH_M = 3000.0
# Points at a time: their arrays stay in the cache of a core.
BLOCK = 16384
# Arrays hold one value for each of these rays and each line.
SHIELDED_BLOCK = 4096
# Values at each step and their differences to the next.
Table = tuple[FloatArray, FloatArray]


def air_transmission(nuclide_name: str, distances_m: FloatArray) -> FloatArray:
    """Return dose rate in air over that without air, for a nuclide, shape of `distances_m`.

    The sum over the lines of share * exp(-mu r) * B(mu r), with the build-up B of air.
    Interpolated from a table; beyond 3 km it stays what it is there.
    """
    return interpolated(transmission_table(nuclide_name), distances_m)


def interpolated(table: Table, distances_m: FloatArray) -> FloatArray:
    """Return the values of a table at distances, those of its end beyond it."""
    values, slopes = table
    flat = np.ravel(distances_m)
    result = np.empty_like(flat)
    for start in range(0, flat.size, BLOCK):
        places = flat[start : start + BLOCK] * (1.0 / STEP_M)
        np.minimum(places, float(len(slopes) - 1), out=places)
        indices = places.astype(np.intp)
        places -= indices
        places *= slopes[indices]
        np.add(places, values[indices], out=result[start : start + BLOCK])
    return result.reshape(np.shape(distances_m))


def interpolated_at(table: Table, distance_m: float) -> float:
    """Return the value of a table at one distance, to the last bit as `interpolated` has it."""
    values, slopes = table
    place = min(distance_m * (1.0 / STEP_M), float(len(slopes) - 1))
    index = int(place)
    return float((place - index) * slopes[index] + values[index])


def interpolated_with_slope(
    table: Table, distances_m: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the values of a table at distances and their derivatives, 1/m."""
    values, slopes = table
    places = np.minimum(distances_m * (1.0 / STEP_M), float(len(slopes) - 1))
    indices = places.astype(np.intp)
    steps = slopes[indices]
    return values[indices] + (places - indices) * steps, steps * (1.0 / STEP_M)


def exact_air_transmission(nuclide_name: str, distances_m: FloatArray) -> FloatArray:
    """Return the transmission of air without the table, line by line."""
    return shielded_transmission(nuclide_name, {AIR: distances_m})


def shielded_transmission(nuclide_name: str, lengths_m: Mapping[str, FloatArray]) -> FloatArray:
    """Return dose rate behind materials over that without any.

    `lengths_m` maps names of materials, air among them, to the lengths of n rays within, each of
    shape (n,). Each line is attenuated by all of them; the build-up is that of the material with
    the most mean free paths along the ray, at their sum over all materials: the usual choice for
    point kernels.
    """
    names = tuple(lengths_m)
    lengths = np.stack([np.asarray(lengths_m[name], np.float64) for name in names])
    flat = lengths.reshape(len(names), -1)
    result: FloatArray = np.empty(flat.shape[1])
    for start in range(0, flat.shape[1], SHIELDED_BLOCK):
        rays = slice(start, start + SHIELDED_BLOCK)
        result[rays] = _shielded(nuclide_name, names, flat[:, rays])
    return result.reshape(lengths.shape[1:])


def _shielded(nuclide_name: str, names: tuple[str, ...], lengths: FloatArray) -> FloatArray:
    """Return the transmission of each ray, with `lengths` of shape (materials, rays)."""
    shares, mu, terms = _lines(nuclide_name, names)
    depths = mu @ lengths
    thickest = np.argmax(mu[:, :, None] * lengths, axis=1)
    lines = np.arange(len(shares))[:, None]
    factors = geometric_progression(terms[lines, thickest], depths)
    return np.asarray(shares @ (np.exp(-depths) * factors))


@cache
def _lines(nuclide_name: str, names: tuple[str, ...]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return share, mu of each material and build-up terms of each line that gives dose."""
    source = nuclide(nuclide_name)
    shares = source.dose_shares()
    energies, kept = source.energies_kev[shares > 0.0], shares[shares > 0.0]
    known = [material(name) for name in names]
    mu = np.stack([one.attenuation_per_m(energies) for one in known], axis=1)
    terms = np.stack([one.buildup_terms(energies) for one in known], axis=1)
    return kept, mu, terms


@cache
def transmission_table(nuclide_name: str) -> tuple[FloatArray, FloatArray]:
    """Return the transmission at each step and its difference to the next."""
    distances: FloatArray = np.arange(0.0, REACH_M + 2.0 * STEP_M, STEP_M, dtype=np.float64)
    values = exact_air_transmission(nuclide_name, distances)
    slopes = np.diff(values)
    slopes[-1] = 0.0
    return values[:-1], slopes
