# SPDX-License-Identifier: Apache-2.0
"""What a dense gas does near its release, where the passive plume is too high and too narrow."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from rocsafe_dispersion.agents.agent_table import Agent
from rocsafe_dispersion.plume.dense_gas import LABEL, dense_release

# Distances downwind, metres.
AWAY_M = (25.0, 50.0, 100.0)


def near_field(rate_g_s: float, known: Agent | None, wind_10m_mps: float) -> dict[str, Any]:
    """Return values for JSON, none for an agent that nobody knows or that is not dense.

    Parameters
    ----------
    rate_g_s
        What is released in a second, g/s.
    known
        What is released.
    wind_10m_mps
        Wind speed at 10 m, m/s.
    """
    dense = dense_release(known, rate_g_s, wind_10m_mps) if known else None
    if dense is None:
        return {}
    away_m = np.array(AWAY_M)
    return {
        'dense_gas': {
            'method': LABEL,
            'upwind_m': round(dense.upwind_m(), 1),
            'distances_m': list(AWAY_M),
            'largest_ppm': [round(1e6 * one) for one in dense.volume_shares(away_m).tolist()],
            'half_widths_m': [round(one, 1) for one in dense.half_widths_m(away_m).tolist()],
        }
    }


def near_field_line(values: Mapping[str, Any]) -> str:
    """Return the values of `near_field` in words."""
    rows = zip(values['distances_m'], values['largest_ppm'], values['half_widths_m'], strict=True)
    parts = [f'{ppm} ppm at {away:g} m, {half:g} m to each side' for away, ppm, half in rows]
    return f'near it the gas is dense: {"; ".join(parts)} ({values["method"]})'
