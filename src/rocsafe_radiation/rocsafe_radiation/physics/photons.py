# SPDX-License-Identifier: Apache-2.0
"""Photons in matter: attenuation, energy absorption, build-up and dose conversion.

The tables are those of ``tables/photons.json``, made with their sources by
``tools/radiation_tables.py``. Attenuation includes coherent scattering, as NIST tabulates it.
"""

import json
import math
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray

AIR = 'air'
LOWEST_ENERGY_KEV, HIGHEST_ENERGY_KEV = 20.0, 3000.0
# The coefficients of the standard are fitted up to here; beyond, exp(-40) is negligible.
LARGEST_MEAN_FREE_PATHS = 40.0
TANH_MINUS_2 = math.tanh(-2.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """A material that photons pass.

    Attributes
    ----------
    name
        As in the tables.
    density_kg_m3
        Its density.
    log_energies
        Natural logarithms of the tabulated energies in keV, shape (n,).
    log_mass_attenuation
        Natural logarithms of mu/rho in m^2/kg, shape (n,).
    buildup_log_energies
        Natural logarithms of energies in keV, shape (m,).
    buildup_coefficients
        B, c, a, X, d of the geometric progression, shape (m, 5).
    """

    name: str
    density_kg_m3: float
    log_energies: FloatArray
    log_mass_attenuation: FloatArray
    buildup_log_energies: FloatArray
    buildup_coefficients: FloatArray

    def attenuation_per_m(self, energies_kev: ArrayLike) -> FloatArray:
        """Return the linear attenuation coefficient at each energy, narrow beam, 1/m."""
        logs = np.interp(_log_energies(energies_kev), self.log_energies, self.log_mass_attenuation)
        return np.asarray(np.exp(logs) * self.density_kg_m3)

    def buildup(self, energy_kev: float, mean_free_paths: ArrayLike) -> FloatArray:
        """Return dose of all photons over dose of the unscattered ones, at least 1.

        Geometric progression of ANSI/ANS-6.4.3-1991 for exposure from a point source in an
        infinite medium; `mean_free_paths` beyond 40 count as 40.
        """
        return geometric_progression(self.buildup_terms(energy_kev), np.asarray(mean_free_paths))

    def buildup_terms(self, energies_kev: ArrayLike) -> FloatArray:
        """Return b, c, a, X, d at each energy, interpolated in its logarithm, shape (..., 5)."""
        energies = _log_energies(energies_kev)
        columns = self.buildup_coefficients.T
        return np.stack(
            [np.interp(energies, self.buildup_log_energies, column) for column in columns], axis=-1
        )


def geometric_progression(terms: FloatArray, mean_free_paths: FloatArray) -> FloatArray:
    """Return the build-up at `mean_free_paths`; b, c, a, X, d are the last axis of `terms`."""
    b, c, a, scale, d = np.moveaxis(terms, -1, 0)
    paths = np.clip(mean_free_paths, 0.0, LARGEST_MEAN_FREE_PATHS)
    # For a negative a, x^a is infinite at 0; the build-up is 1 there for any K.
    bounded = np.maximum(paths, 1e-9)
    bend = (np.tanh(bounded / scale - 2.0) - TANH_MINUS_2) / (1.0 - TANH_MINUS_2)
    growth = np.clip(c * bounded**a + d * bend, 1e-6, 1e3)
    is_linear = np.abs(growth - 1.0) < 1e-7
    base = np.where(is_linear, 2.0, growth)
    series = np.where(is_linear, bounded, (base**bounded - 1.0) / (base - 1.0))
    return np.asarray(np.maximum(1.0, np.where(paths > 0.0, 1.0 + (b - 1.0) * series, 1.0)))


def materials() -> tuple[str, ...]:
    """Return the names of all materials."""
    return tuple(_tables()['materials'])


@cache
def material(name: str) -> Material:
    """Return the material `name`.

    Raises
    ------
    ValueError
        If there is none of that name.
    """
    known = _tables()['materials']
    if name not in known:
        raise ValueError(f'material = {name!r} must be one of: {", ".join(known)}')
    entry = known[name]
    buildup = np.array(entry['buildup'])
    return Material(
        name=name,
        density_kg_m3=entry['density_g_cm3'] * 1e3,
        log_energies=np.log(entry['energies_kev']),
        log_mass_attenuation=np.log(np.array(entry['mass_attenuation_cm2_g']) * 0.1),
        buildup_log_energies=np.log(buildup[:, 0]),
        buildup_coefficients=buildup[:, 1:],
    )


def air_energy_absorption_m2_kg(energies_kev: ArrayLike) -> FloatArray:
    """Return mu_en/rho of dry air at each energy, m^2/kg."""
    table = _tables()['air_energy_absorption']
    logs = np.interp(
        _log_energies(energies_kev),
        np.log(table['energies_kev']),
        np.log(np.array(table['mass_energy_absorption_cm2_g']) * 0.1),
    )
    return np.asarray(np.exp(logs))


def dose_per_kerma_sv_gy(energies_kev: ArrayLike) -> FloatArray:
    """Return ambient dose equivalent H*(10) over air kerma at each energy, Sv/Gy."""
    table = _tables()['dose_per_kerma']
    return np.asarray(
        np.interp(_log_energies(energies_kev), np.log(table['energies_kev']), table['sv_per_gy'])
    )


def _log_energies(energies_kev: ArrayLike) -> FloatArray:
    energies = np.asarray(energies_kev, np.float64)
    return np.asarray(np.log(np.clip(energies, 1.0, HIGHEST_ENERGY_KEV)))


@cache
def _tables() -> dict[str, Any]:
    text = resources.files('rocsafe_radiation').joinpath('tables/photons.json').read_text('utf-8')
    tables: dict[str, Any] = json.loads(text)
    return tables
