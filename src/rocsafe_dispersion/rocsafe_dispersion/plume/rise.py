# SPDX-License-Identifier: Apache-2.0
"""Rise of a plume that is lighter than the air.

Briggs 1975 (Plume rise predictions, in Haugen: Lectures on air pollution and environmental impact
analyses): 1.6 F^(1/3) x^(2/3) / u up to where turbulence ends it, and at most
2.6 (F / (u s))^(1/3) in stable air.
"""

import math

import numpy as np

from rocsafe_dispersion.agents.agent_table import (
    AIR_G_MOL,
    GAS_CONSTANT,
    ROOM_TEMPERATURE_K,
    STANDARD_PRESSURE_PA,
    Agent,
)
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between, require_not_negative
from rocsafe_geo.wind.similarity import KARMAN, SurfaceLayer

GRAVITY_MPS2 = 9.81
FREEZING_K = 273.15
# The height at which the layer of air is met, for its growth of temperature, metres.
_MET_AT_M = 10.0


def buoyancy_m4_s3(agent: Agent, rate_g_s: float, temperature_c: float) -> float:
    """Return the flux of buoyancy F of a gas that leaves pure, m^4/s^3; 0 if it is heavy.

    Parameters
    ----------
    agent
        The gas; its molar mass must be known.
    rate_g_s
        Its rate, g/s.
    temperature_c
        Its temperature, -200 to 2000 degrees Celsius; the air has 20.
    """
    require_between('temperature_c', temperature_c, -200.0, 2000.0, 'degrees Celsius')
    require_not_negative('rate_g_s', rate_g_s, 'g/s')
    if agent.molar_mass_g_mol is None:
        raise ValueError(f'{agent.name}: the molar mass must be known for its buoyancy')
    kelvin = temperature_c + FREEZING_K
    flow = rate_g_s / agent.molar_mass_g_mol * GAS_CONSTANT * kelvin / STANDARD_PRESSURE_PA
    ratio = agent.molar_mass_g_mol / AIR_G_MOL * ROOM_TEMPERATURE_K / kelvin
    return GRAVITY_MPS2 / math.pi * flow * max(1.0 - ratio, 0.0)


def rise_m(distances_m: FloatArray, buoyancy_m4_s3: float, layer: SurfaceLayer) -> FloatArray:
    """Return how far a plume has risen after distances, of their shape, metres.

    Parameters
    ----------
    distances_m
        Distances downwind, metres.
    buoyancy_m4_s3
        Flux of buoyancy, not below 0, m^4/s^3.
    layer
        The air; its wind at 10 m counts.
    """
    flux = require_not_negative('buoyancy_m4_s3', buoyancy_m4_s3, 'm^4/s^3')
    speed = float(layer.speed_mps(_MET_AT_M))
    ends_m = 49.0 * flux**0.625 if flux < 55.0 else 119.0 * flux**0.4
    rise = 1.6 * np.cbrt(flux) * np.minimum(distances_m, ends_m) ** (2.0 / 3.0) / speed
    if layer.obukhov_length_m > 0.0 and math.isfinite(layer.obukhov_length_m):
        rise = np.minimum(rise, 2.6 * np.cbrt(flux / (speed * _restoring_s2(layer))))
    return np.asarray(rise)


def _restoring_s2(layer: SurfaceLayer) -> float:
    """Return s = g/T d(theta)/dz of stable air, 1/s^2 (similarity, 1 + 5 z/L)."""
    length = layer.obukhov_length_m
    slope = layer.friction_velocity_mps**2 / (KARMAN * length) / (KARMAN * _MET_AT_M)
    return slope * (1.0 + 5.0 * _MET_AT_M / length)
