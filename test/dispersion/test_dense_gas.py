# SPDX-License-Identifier: Apache-2.0
"""Dense gas by Britter and McQuaid against the example of CCPS 1999."""

import importlib.machinery
import math
import sys
import types

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_dispersion.agents.agent_table import agent
from rocsafe_dispersion.mission_gas.near_field import AWAY_M, near_field, near_field_line
from rocsafe_dispersion.plume import degadis
from rocsafe_dispersion.plume.dense_gas import LABEL, DenseRelease, dense_release
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume
from rocsafe_geo.wind.stability import layer_of_class
from rocsafe_geo.wind.wind_vector import WindVector

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


def told(rate_g_s: float, name: str, speed_mps: float):
    """Return the near field of a leak in class D."""
    known = agent(name) if name else None
    return near_field(rate_g_s, known, layer_of_class('D', speed_mps, 10.0, 0.03), 'D')


def test_a_leak_of_chlorine_is_dense_near_by(monkeypatch):
    """Told beside the passive plume, with the method; little of it is not, nor ammonia."""
    monkeypatch.setattr(degadis, 'MODULE', 'a_module_that_is_not_installed')
    values = told(2000.0, 'chlorine', 3.0)['dense_gas']
    assert values['largest_ppm'] == sorted(values['largest_ppm'], reverse=True)
    assert values['half_widths_m'] == sorted(values['half_widths_m'])
    assert 'screening by Britter and McQuaid' in near_field_line(values)
    assert told(0.01, 'chlorine', 6.0) == {}
    assert told(2000.0, 'ammonia', 3.0) == {}
    assert told(2000.0, '', 3.0) == {}


def test_a_model_that_finds_no_solution_leaves_the_screening(monkeypatch):
    """It gets the deck of the release, in the order of DEGADIS."""
    decks = []

    def run_steady(path):
        decks.append(path.read_text().splitlines())
        raise RuntimeError('no solution')

    monkeypatch.setitem(sys.modules, 'degadisx', types.SimpleNamespace(
        run_steady=run_steady, __spec__=importlib.machinery.ModuleSpec('degadisx', None)
    ))  # fmt: skip
    values = told(2000.0, 'chlorine', 3.0)['dense_gas']
    assert values['method'] == LABEL
    (deck,) = decks
    # Wind at a height over a roughness, class, averaging time.
    assert deck[4:7] == ['3 10 0.03', '4', '0 600']
    rate_kg_s, radius_m = map(float, deck[-6].split()[1:3])
    assert rate_kg_s == pytest.approx(2.0, rel=1e-6)
    assert radius_m == pytest.approx(math.sqrt(2.0 / 3.61 / 3.0 / math.pi), rel=0.02)


def test_degadis_is_between_the_plume_and_the_screening():
    """Where it is installed: a mean of ten minutes, wider and lower than the screening."""
    pytest.importorskip('degadisx', reason='the extra rocsafe_dispersion[dense]')
    values = told(1000.0, 'chlorine', 4.0)['dense_gas']
    assert values['method'] == degadis.LABEL
    layer = layer_of_class('D', 4.0, 10.0, 0.03)
    plume = SteadyPlume(
        release=Release(place_m=(0.0, 0.0), rate_g_s=1000.0),
        travel=similarity_travel(layer, 0.0),
        wind=WindVector(towards_east_mps=4.0, towards_north_mps=0.0),
    )
    places = np.column_stack([AWAY_M, np.zeros(3), np.zeros(3)])
    passive = [agent('chlorine').ppm(one) for one in plume.concentrations_g_m3(places).tolist()]
    dense = dense_release(agent('chlorine'), 1000.0, 4.0)
    assert dense is not None
    screening = 1e6 * dense.volume_shares(np.array(AWAY_M))
    told_ppm = np.array(values['largest_ppm'])
    assert (told_ppm < screening).all()
    assert (told_ppm[1:] > 1.1 * np.array(passive[1:])).all()
