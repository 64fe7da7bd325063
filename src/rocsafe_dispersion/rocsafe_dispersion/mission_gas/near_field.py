# SPDX-License-Identifier: Apache-2.0
"""What a dense gas does near its release, where the passive plume is too high and too narrow."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from rocsafe_dispersion.agents.agent_table import Agent
from rocsafe_dispersion.plume import degadis, dense_gas
from rocsafe_dispersion.plume.degadis import degadis_profile
from rocsafe_dispersion.plume.dense_gas import dense_release
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.stability import StabilityClass

# Distances downwind, metres.
AWAY_M = (25.0, 50.0, 100.0)


def near_field(
    rate_g_s: float, known: Agent | None, layer: SurfaceLayer, stability: StabilityClass
) -> dict[str, Any]:
    """Return values for JSON, none for an agent that nobody knows or that is not dense.

    Parameters
    ----------
    rate_g_s
        What is released in a second, g/s.
    known
        What is released.
    layer, stability
        The air.
    """
    wind_10m_mps = float(layer.speed_mps(10.0))
    dense = dense_release(known, rate_g_s, wind_10m_mps) if known else None
    if known is None or dense is None:
        return {}
    away_m = np.array(AWAY_M)
    profile = degadis_profile(dense, known.molar_mass_g_mol or math.nan, layer, stability)
    shares, widths_m = dense.volume_shares(away_m), dense.half_widths_m(away_m)
    if profile is not None:
        shares, widths_m = profile.at(away_m)
    return {
        'dense_gas': {
            'method': dense_gas.LABEL if profile is None else degadis.LABEL,
            'upwind_m': round(dense.upwind_m(), 1),
            'distances_m': list(AWAY_M),
            'largest_ppm': [round(1e6 * one) for one in shares.tolist()],
            'half_widths_m': [round(one, 1) for one in widths_m.tolist()],
        }
    }


def near_field_line(values: Mapping[str, Any]) -> str:
    """Return the values of `near_field` in words."""
    rows = zip(values['distances_m'], values['largest_ppm'], values['half_widths_m'], strict=True)
    parts = [f'{ppm} ppm at {away:g} m, {half:g} m to each side' for away, ppm, half in rows]
    return f'near it the gas is dense: {"; ".join(parts)} ({values["method"]})'
