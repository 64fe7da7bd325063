# SPDX-License-Identifier: Apache-2.0
"""Published properties and response levels of agents, from ``agents.json``.

What is not in the sources is unknown: None, or NaN among levels.
"""

import json
import math
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

from rocsafe_geo.limits import require_between, require_not_negative, require_positive

GAS_CONSTANT = 8.314462618
STANDARD_PRESSURE_PA, ROOM_TEMPERATURE_K = 101_325.0, 293.15
AIR_G_MOL = 28.965
LEVELS = (1, 2, 3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Agent:
    """An agent.

    Attributes
    ----------
    name
        Name in scenarios and files.
    category
        Class of its effect, or ``industrial``.
    is_of_seed
        Whether it is one of the 31 agents of the seed's identification.
    is_industrial
        Whether a scenario may release it.
    cas
        CAS number.
    molar_mass_g_mol
        Molar mass, g/mol.
    boiling_c
        Boiling point, degrees Celsius.
    ionisation_ev
        Ionisation energy, eV; a lamp of less energy does not see it.
    load_exponent
        n of the toxic load C^n t.
    aegl_ppm
        Minutes of exposure, and the levels AEGL-1 to AEGL-3 for them, ppm.
    erpg_ppm
        Levels ERPG-1 to ERPG-3 (60 minutes), ppm.
    """

    name: str
    category: str
    is_of_seed: bool
    is_industrial: bool
    cas: str | None
    molar_mass_g_mol: float | None
    boiling_c: float | None
    ionisation_ev: float | None
    load_exponent: float | None
    aegl_ppm: tuple[tuple[float, tuple[float, float, float]], ...]
    erpg_ppm: tuple[float, float, float] | None

    @property
    def is_heavy(self) -> bool | None:
        """Whether its gas is heavier than air at the same temperature; None: unknown."""
        return None if self.molar_mass_g_mol is None else self.molar_mass_g_mol > AIR_G_MOL

    def aegl_at_ppm(self, level: int, minutes: float) -> float | None:
        """Return an AEGL at a published time of exposure, or None if there is none.

        Nothing is interpolated between times.
        """
        if level not in LEVELS:
            raise ValueError(f'level is {level!r}: must be 1, 2 or 3')
        found = dict(self.aegl_ppm).get(float(minutes), (math.nan,) * 3)[level - 1]
        return None if math.isnan(found) else found

    def ppm(
        self,
        concentration_g_m3: float,
        temperature_k: float = ROOM_TEMPERATURE_K,
        pressure_pa: float = STANDARD_PRESSURE_PA,
    ) -> float:
        """Return a concentration as parts per million of the volume, at ambient conditions.

        Raises
        ------
        ValueError
            If the molar mass is unknown or a value out of range.
        """
        return concentration_g_m3 * self._ppm_per_g_m3(temperature_k, pressure_pa)

    def g_m3(
        self,
        ppm: float,
        temperature_k: float = ROOM_TEMPERATURE_K,
        pressure_pa: float = STANDARD_PRESSURE_PA,
    ) -> float:
        """Return parts per million as a concentration, g/m^3; the reverse of `ppm`."""
        return require_not_negative('ppm', ppm) / self._ppm_per_g_m3(temperature_k, pressure_pa)

    def _ppm_per_g_m3(self, temperature_k: float, pressure_pa: float) -> float:
        if self.molar_mass_g_mol is None:
            raise ValueError(f'{self.name}: the molar mass must be known to convert to ppm')
        require_between('temperature_k', temperature_k, 150.0, 400.0, 'K')
        require_positive('pressure_pa', pressure_pa, 'Pa')
        return 1e6 * GAS_CONSTANT * temperature_k / (pressure_pa * self.molar_mass_g_mol)


PARTICLES = Agent(
    name='particles', category='particles', is_of_seed=False, is_industrial=False, cas=None,
    molar_mass_g_mol=None, boiling_c=None, ionisation_ev=None, load_exponent=None, aegl_ppm=(),
    erpg_ppm=None,
)  # fmt: skip
"""Particles that stand for biological ones; not in the table."""


@lru_cache(maxsize=1)
def agents() -> dict[str, Agent]:
    """Return all agents of the table by their names."""
    text = files('rocsafe_dispersion.agents').joinpath('agents.json').read_text(encoding='utf-8')
    return {row['name']: _agent(row) for row in json.loads(text)['agents']}


def agent(name: str) -> Agent:
    """Return an agent of the table.

    Raises
    ------
    ValueError
        If it has none of that name.
    """
    if name not in agents():
        raise ValueError(f'agent {name!r} is not known; known: {", ".join(sorted(agents()))}')
    return agents()[name]


def released_agent(name: str) -> Agent:
    """Return an agent that a scenario may release: an industrial chemical of known molar mass.

    Raises
    ------
    ValueError
        If it is not known or not one of these.
    """
    found = agent(name)
    if not found.is_industrial or found.molar_mass_g_mol is None:
        names = sorted(one.name for one in agents().values() if one.is_industrial)
        raise ValueError(
            f'agent {name!r} cannot be released: scenarios hold industrial chemicals only: '
            f'{", ".join(names)}'
        )
    return found


def _agent(row: dict[str, object]) -> Agent:
    aegl: dict[str, list[float | None]] = row['aegl_ppm']  # type: ignore[assignment]
    erpg: list[float | None] | None = row['erpg_ppm']  # type: ignore[assignment]
    levels = tuple((float(minutes), _levels(values)) for minutes, values in aegl.items())
    known = row | {'aegl_ppm': levels, 'erpg_ppm': _levels(erpg) if erpg else None}
    return Agent(**known)  # type: ignore[arg-type]


def _levels(values: list[float | None]) -> tuple[float, float, float]:
    first, second, third = (math.nan if value is None else float(value) for value in values)
    return first, second, third
