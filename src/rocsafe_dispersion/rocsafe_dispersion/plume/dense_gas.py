# SPDX-License-Identifier: Apache-2.0
"""Dense gas near a steady release at the ground: a screening figure, not a prediction.

Britter and McQuaid 1988 (HSE contract research report 17/1988) with the lines of CCPS 1999,
Guidelines for Consequence Analysis of Chemical Releases: flat ground without obstacles.
"""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.agents.agent_table import (
    GAS_CONSTANT,
    ROOM_TEMPERATURE_K,
    STANDARD_PRESSURE_PA,
    Agent,
)
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_positive

GRAVITY_MPS2, ZERO_K = 9.80616, 273.15
LABEL = 'dense gas, screening by Britter and McQuaid'
# For each share of the concentration at the release: upper ends of alpha, and slope and intercept
# of log10 of the distance in units of sqrt(volume flow / wind), of which the last holds above.
_LINES: dict[float, tuple[tuple[float, ...], tuple[tuple[float, float], ...]]] = {
    0.10: ((-0.55, -0.14), ((0.0, 1.75), (0.24, 1.88), (-0.50, 1.78))),
    0.05: ((-0.68, -0.29, -0.18), ((0.0, 1.92), (0.36, 2.16), (0.0, 2.06), (-0.56, 1.96))),
    0.02: ((-0.69, -0.31, -0.16), ((0.0, 2.08), (0.45, 2.39), (0.0, 2.25), (-0.54, 2.16))),
    0.01: ((-0.70, -0.29, -0.20), ((0.0, 2.25), (0.49, 2.59), (0.0, 2.45), (-0.52, 2.35))),
    0.005: ((-0.67, -0.28, -0.15), ((0.0, 2.40), (0.59, 2.80), (0.0, 2.63), (-0.48, 2.56))),
    0.002: ((-0.69, -0.25, -0.13), ((0.0, 2.60), (0.39, 2.87), (0.0, 2.77), (-0.50, 2.71))),
}
LARGEST_ALPHA = 1.0
_NEAR_ROWS, _NEAR_CONSTANT = 30.0, 306.0


@dataclass(frozen=True, slots=True, kw_only=True)
class DenseRelease:
    """A steady release of cold or heavy gas at the ground.

    Attributes
    ----------
    volume_flow_m3_s
        Of the gas at its release, m^3/s.
    density_kg_m3
        Of the gas at its release, kg/m^3, above that of the air.
    temperature_k
        Of the gas at its release, K.
    wind_10m_mps
        Wind speed at 10 m, m/s.
    air_density_kg_m3, air_temperature_k
        Of the air.
    """

    volume_flow_m3_s: float
    density_kg_m3: float
    temperature_k: float
    wind_10m_mps: float
    air_density_kg_m3: float = 1.2
    air_temperature_k: float = 293.15

    def __post_init__(self) -> None:
        for name in self.__slots__:
            require_positive(name, getattr(self, name))
        if self.density_kg_m3 <= self.air_density_kg_m3:
            raise ValueError(
                f'density_kg_m3 is {self.density_kg_m3:g}: must be above that of the air, '
                f'{self.air_density_kg_m3:g}; take the passive plume'
            )
        if self.alpha > LARGEST_ALPHA:
            raise ValueError(
                f'alpha of the dense release is {self.alpha:.2f}: must be at most '
                f'{LARGEST_ALPHA:g}; the wind is too weak for this method'
            )

    @property
    def buoyancy_mps2(self) -> float:
        """Reduced gravity at the release, m/s^2."""
        return GRAVITY_MPS2 * (self.density_kg_m3 / self.air_density_kg_m3 - 1.0)

    @property
    def alpha(self) -> float:
        """Parameter of the lines: 0.2 log10(g'^2 q / u^5)."""
        ratio = self.buoyancy_mps2**2 * self.volume_flow_m3_s / self.wind_10m_mps**5
        return 0.2 * math.log10(ratio)

    @property
    def length_m(self) -> float:
        """Unit of distance: sqrt(q / u), metres."""
        return math.sqrt(self.volume_flow_m3_s / self.wind_10m_mps)

    @property
    def is_dense(self) -> bool:
        """Whether the criterion of Britter and McQuaid holds: (g' q / (u^3 D))^(1/3) >= 0.15."""
        flow = self.buoyancy_mps2 * self.volume_flow_m3_s
        return bool(np.cbrt(flow / self.wind_10m_mps**3 / self.length_m) >= 0.15)

    def volume_shares(self, distances_m: FloatArray) -> FloatArray:
        """Return the largest share of the gas in the air at distances downwind, (n,)."""
        beyond = np.asarray(distances_m, float) / self.length_m
        levels, rows = self._line()
        logs = np.log10(np.maximum(beyond, 1e-9))
        near = _NEAR_CONSTANT / (_NEAR_CONSTANT + np.maximum(beyond, 0.0) ** 2)
        between = np.interp(logs, rows, levels)
        far = levels[-1] * (10.0 ** rows[-1] / np.maximum(beyond, 1e-9)) ** 2
        share = np.where(logs > rows[-1], far, between)
        share = np.where(beyond <= 10.0 ** rows[0], near, share)
        # The gas is colder than the air: less of it is needed for the same share by heat.
        return np.asarray(
            share / (share + (1.0 - share) * self.temperature_k / self.air_temperature_k)
        )

    def half_widths_m(self, distances_m: FloatArray) -> FloatArray:
        """Return the half width of the cloud at distances downwind, (n,), metres."""
        scale = self._buoyancy_length_m()
        distances = np.maximum(np.asarray(distances_m, float), 0.0)
        return self.length_m + 8.0 * scale + 2.5 * np.cbrt(scale * distances**2)

    def upwind_m(self) -> float:
        """Return how far the cloud reaches against the wind, metres."""
        return 0.5 * self.length_m + 2.0 * self._buoyancy_length_m()

    def _buoyancy_length_m(self) -> float:
        return self.buoyancy_mps2 * self.volume_flow_m3_s / self.wind_10m_mps**3

    def _line(self) -> tuple[FloatArray, FloatArray]:
        """Return shares and log10 of the distances at which they are reached."""
        found = [(share, _value(*line, self.alpha)) for share, line in _LINES.items()]
        shares, rows = np.array(found).T
        if rows[0] > math.log10(_NEAR_ROWS):
            start = _NEAR_CONSTANT / (_NEAR_ROWS**2 + _NEAR_CONSTANT)
            shares = np.concatenate([[start], shares])
            rows = np.concatenate([[math.log10(_NEAR_ROWS)], rows])
        return shares, rows


def dense_release(agent: Agent, rate_g_s: float, wind_10m_mps: float) -> DenseRelease | None:
    """Return a steady release at the ground that is dense, None if it is none or nobody can tell.

    It is a vapour at the boiling point of the agent, or as warm as the air.
    """
    if agent.molar_mass_g_mol is None:
        return None
    boiling_k = math.inf if agent.boiling_c is None else agent.boiling_c + ZERO_K
    temperature_k = min(boiling_k, ROOM_TEMPERATURE_K)
    molar_m3 = GAS_CONSTANT * temperature_k / STANDARD_PRESSURE_PA
    try:
        found = DenseRelease(
            volume_flow_m3_s=rate_g_s / agent.molar_mass_g_mol * molar_m3,
            density_kg_m3=1e-3 * agent.molar_mass_g_mol / molar_m3,
            temperature_k=temperature_k,
            wind_10m_mps=wind_10m_mps,
            air_temperature_k=ROOM_TEMPERATURE_K,
        )
    except ValueError:
        return None
    return found if found.is_dense else None


def _value(ends: tuple[float, ...], lines: tuple[tuple[float, float], ...], alpha: float) -> float:
    slope, intercept = lines[int(np.searchsorted(ends, alpha))]
    return slope * alpha + intercept
