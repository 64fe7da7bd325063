# SPDX-License-Identifier: Apache-2.0
"""The table of agents: what the seed lists, published levels, conversions, unknowns."""

import json
import math
from collections import Counter
from importlib.resources import files
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_dispersion.agents.agent_table import agent, agents, released_agent


def test_the_seed_has_31_agents_in_7_categories():
    """As in its model of identification."""
    found = Counter(one.category for one in agents().values() if one.is_of_seed)
    assert found == {
        'nerve': 4, 'choking': 3, 'blister': 10, 'blood': 3, 'vomiting': 3, 'tear': 6,
        'incapacitating': 2,
    }  # fmt: skip


def test_names_are_unique_and_columns_have_sources():
    """One row an agent; a source for each kind of value."""
    text = files('rocsafe_dispersion.agents').joinpath('agents.json').read_text(encoding='utf-8')
    document = json.loads(text)
    assert len(document['agents']) == len(agents())
    assert all(document['sources'].values())


@pytest.mark.parametrize(
    ('name', 'levels'),
    [
        ('chlorine', (0.5, 2.0, 20.0)),
        ('ammonia', (30.0, 160.0, 1100.0)),
        ('hydrogen_cyanide', (2.0, 7.1, 15.0)),
        ('hydrogen_sulphide', (0.51, 27.0, 50.0)),
        ('hydrogen_fluoride', (1.0, 24.0, 44.0)),
        ('phosgene', (None, 0.3, 0.75)),
    ],
)
def test_levels_at_60_minutes(name, levels):
    """Of the EPA."""
    assert tuple(agent(name).aegl_at_ppm(level, 60.0) for level in (1, 2, 3)) == levels


def test_levels_do_not_grow_with_time_and_grow_with_severity():
    """For all agents that have them."""
    for one in agents().values():
        for _, (first, second, third) in one.aegl_ppm:
            known = [value for value in (first, second, third) if not math.isnan(value)]
            assert known == sorted(known), one.name
        for level in (0, 1, 2):
            over_time = [values[level] for _, values in one.aegl_ppm]
            assert not any(b > a for a, b in pairwise(over_time))


def test_toxic_load_is_that_of_the_levels():
    """C^n t of AEGL-3 is the same at all times within 7 % where n is known."""
    for one in agents().values():
        if one.load_exponent is not None:
            loads = [values[2] ** one.load_exponent * minutes for minutes, values in one.aegl_ppm]
            assert max(loads) / min(loads) < 1.07, one.name


def test_nothing_is_interpolated():
    """A time without a published level has none, and so has an agent without."""
    assert agent('chlorine').aegl_at_ppm(2, 45.0) is None
    assert agent('lewisite').aegl_at_ppm(2, 60.0) is None
    assert agent('lewisite').is_heavy is None


def test_ppm_at_known_conditions():
    """1 ppm of chlorine at 20 degrees is 2.95 mg/m^3 (molar volume 24.055 l)."""
    assert agent('chlorine').g_m3(1.0) == pytest.approx(70.91 / 24.055 * 1e-3, rel=1e-3)


@given(st.sampled_from(['chlorine', 'ammonia']), st.floats(1e-3, 1e5), st.floats(230.0, 320.0))
def test_ppm_survives_a_round_trip(name, ppm, temperature):
    """At any temperature."""
    one = agent(name)
    assert one.ppm(one.g_m3(ppm, temperature), temperature) == pytest.approx(ppm)


@pytest.mark.parametrize(
    ('call', 'named'),
    [
        (lambda: agent('water'), r"agent 'water' is not known"),
        (lambda: released_agent('sarin'), r'industrial chemicals only'),
        (lambda: released_agent('vx'), r'industrial chemicals only'),
        (lambda: agent('lewisite').ppm(1.0), r'molar mass'),
        (lambda: agent('chlorine').ppm(1.0, 20.0), r'temperature_k'),
        (lambda: agent('chlorine').aegl_at_ppm(4, 60.0), r'level'),
    ],
)
def test_bad_questions_are_refused(call, named):
    """In one line."""
    with pytest.raises(ValueError, match=named):
        call()


def test_gases_that_a_scenario_may_release():
    """Those of the issue are among them."""
    for name in ('chlorine', 'ammonia', 'sulphur_dioxide'):
        assert released_agent(name).is_industrial
