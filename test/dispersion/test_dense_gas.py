# SPDX-License-Identifier: Apache-2.0
"""Dense gas by Britter and McQuaid against the example of CCPS 1999."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_dispersion.agents.agent_table import agent
from rocsafe_dispersion.mission_gas.near_field import near_field, near_field_line
from rocsafe_dispersion.plume.dense_gas import DenseRelease

# Liquid natural gas, 0.23 m^3/s of liquid of 425.6 kg/m^3, as gas of 1.76 kg/m^3 at -162 degrees.
LNG = DenseRelease(
    volume_flow_m3_s=0.23 * 425.6 / 1.76,
    density_kg_m3=1.76,
    temperature_k=273.15 - 162.0,
    wind_10m_mps=10.9,
    air_density_kg_m3=101325.0 * 0.028965 / (8.314462618 * 298.0),
    air_temperature_k=298.0,
)


def test_example_of_the_guidelines():
    """Near field, between the lines, and far field, as GasDispersion.jl computes them."""
    found = LNG.volume_shares(np.array([2.26 * 20.0, 367.0, 1200.0]))
    assert found == pytest.approx([0.6720, 0.05072, 0.004921], rel=0.01)
    assert LNG.is_dense


@given(st.floats(1.0, 80.0), st.floats(2.0, 12.0), st.floats(1.3, 3.0))
def test_concentration_falls_with_distance(flow: float, wind: float, density: float):
    """From 1 at the release; the cloud widens."""
    try:
        release = DenseRelease(
            volume_flow_m3_s=flow, density_kg_m3=density, temperature_k=250.0, wind_10m_mps=wind
        )
    except ValueError:
        return
    distances = np.geomspace(0.1, 5000.0, 200)
    shares = release.volume_shares(distances)
    assert shares[0] == pytest.approx(1.0, abs=0.01)
    # Near field and lines meet with a step where alpha is large: the method has it.
    assert (np.diff(shares) <= 1e-9).mean() > 0.98
    assert (np.diff(release.half_widths_m(distances)) >= 0.0).all()


@pytest.mark.parametrize(
    ('changed', 'named'),
    [
        ({'density_kg_m3': 1.0}, 'density_kg_m3'),
        ({'wind_10m_mps': 0.2}, 'alpha'),
        ({'volume_flow_m3_s': -1.0}, 'volume_flow_m3_s'),
        ({'temperature_k': float('nan')}, 'temperature_k'),
    ],
)
def test_bad_values_are_refused(changed, named):
    """By their name."""
    values = {
        'volume_flow_m3_s': 10.0,
        'density_kg_m3': 2.0,
        'temperature_k': 250.0,
        'wind_10m_mps': 5.0,
    }
    with pytest.raises(ValueError, match=named):
        DenseRelease(**(values | changed))


def test_a_leak_of_chlorine_is_dense_near_by():
    """Told beside the passive plume, with the method; little of it is not, nor ammonia."""
    values = near_field(2000.0, agent('chlorine'), 3.0)['dense_gas']
    assert values['largest_ppm'] == sorted(values['largest_ppm'], reverse=True)
    assert values['half_widths_m'] == sorted(values['half_widths_m'])
    assert 'screening by Britter and McQuaid' in near_field_line(values)
    assert near_field(0.01, agent('chlorine'), 6.0) == {}
    assert near_field(2000.0, agent('ammonia'), 3.0) == {}
    assert near_field(2000.0, None, 3.0) == {}
