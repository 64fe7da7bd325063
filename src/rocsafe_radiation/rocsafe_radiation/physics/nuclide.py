# SPDX-License-Identifier: Apache-2.0
"""Nuclides: what they emit, how fast they decay, and the dose rate of a becquerel."""

import json
import math
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.physics.photons import (
    LOWEST_ENERGY_KEV,
    air_energy_absorption_m2_kg,
    dose_per_kerma_sv_gy,
)

JOULE_PER_KEV = 1.602176634e-16
SECONDS_PER_HOUR = 3600.0
BECQUEREL_PER_GBQ = 1e9
MICRO = 1e6
# A source of unknown nuclide counts as this: common among orphan sources, of middle energy.
DEFAULT_NUCLIDE = 'Cs-137'


@dataclass(frozen=True, slots=True, kw_only=True)
class Nuclide:
    """A nuclide with the daughters in equilibrium with it.

    Attributes
    ----------
    name
        For instance ``Cs-137``.
    half_life_s
        Half-life of the parent, seconds.
    energies_kev
        Photon lines, gamma and x rays of 15 keV and more, ascending, shape (n,).
    intensities
        Photons of each line for one decay of the parent, shape (n,).
    """

    name: str
    half_life_s: float
    energies_kev: FloatArray
    intensities: FloatArray

    def kerma_constants_ugy(self, cutoff_kev: float = LOWEST_ENERGY_KEV) -> FloatArray:
        """Return the air kerma rate of each line, microgray m^2/(h GBq), shape (n,).

        I E (mu_en/rho) / (4 pi r^2) at r = 1 m in vacuum; lines below `cutoff_kev` give 0.
        """
        absorbed = (
            self.energies_kev * JOULE_PER_KEV * air_energy_absorption_m2_kg(self.energies_kev)
        )
        per_becquerel_gy = self.intensities * absorbed / (4.0 * math.pi)
        kept = self.energies_kev >= cutoff_kev
        return np.asarray(per_becquerel_gy * BECQUEREL_PER_GBQ * SECONDS_PER_HOUR * MICRO * kept)

    def line_dose_constants_usvh(self) -> FloatArray:
        """Return the ambient dose equivalent rate of each line, uSv m^2/(h GBq), shape (n,)."""
        doses = self.kerma_constants_ugy() * dose_per_kerma_sv_gy(self.energies_kev)
        return np.asarray(doses)

    def dose_constant_usvh(self) -> float:
        """Return the ambient dose equivalent rate H*(10), microsievert m^2/(h GBq)."""
        return float(self.line_dose_constants_usvh().sum())

    def sigma_usvps(self, activity_gbq: float, age_s: float = 0.0) -> float:
        """Return the lossless dose rate at 1 m of a source, microsievert per second.

        `activity_gbq` is the activity `age_s` seconds ago.
        """
        decayed = activity_gbq * self.remaining_fraction(age_s)
        return self.dose_constant_usvh() * decayed / SECONDS_PER_HOUR

    def remaining_fraction(self, age_s: float) -> float:
        """Return the share of the activity left after `age_s` seconds, 2^(-age/half-life)."""
        return float(2.0 ** (-age_s / self.half_life_s))

    def dose_shares(self) -> FloatArray:
        """Return the share of each line in the dose rate near the source, shape (n,)."""
        doses = self.line_dose_constants_usvh()
        return np.asarray(doses / doses.sum())


def nuclide_names() -> tuple[str, ...]:
    """Return the names of all known nuclides."""
    return tuple(_tables())


@cache
def nuclide(name: str) -> Nuclide:
    """Return the nuclide `name`.

    Raises
    ------
    ValueError
        If it is not in the table.
    """
    known = _tables()
    if name not in known:
        raise ValueError(f'nuclide = {name!r} must be one of: {", ".join(known)}')
    lines = np.array(known[name]['lines_kev'])
    return Nuclide(
        name=name,
        half_life_s=known[name]['half_life_s'],
        energies_kev=lines[:, 0],
        intensities=lines[:, 1],
    )


@cache
def _tables() -> dict[str, Any]:
    text = resources.files('rocsafe_radiation').joinpath('tables/nuclides.json').read_text('utf-8')
    tables: dict[str, Any] = json.loads(text)
    return tables
