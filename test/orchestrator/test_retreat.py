# SPDX-License-Identifier: Apache-2.0
"""The way home of least dose."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_orchestrator.watches.retreat import Danger, EstimatedSource, retreat

HEIGHT_M = 30.0
SOURCE = EstimatedSource(place_enu=(0.0, 0.0, 0.0), at_1m_usvh=1e8)
# Beyond the source, seen from home.
DANGER = Danger(here_enu=(60.0, 0.0, HEIGHT_M), home=(-200.0, 0.0), speed_mps=5.0)
places = st.tuples(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0))
sources = st.lists(
    st.builds(
        EstimatedSource,
        place_enu=st.tuples(st.floats(-200.0, 200.0), st.floats(-200.0, 200.0), st.just(0.0)),
        at_1m_usvh=st.floats(1e3, 1e9),
    ),
    min_size=1,
    max_size=3,
).map(tuple)


def test_way_leads_around_a_source():
    """The straight way leads over it."""
    way = retreat(replace(DANGER, sources=(SOURCE,)))
    corners = [(60.0, 0.0), *way.bends, (-200.0, 0.0)]
    assert way.bends
    assert way.dose_usv < 0.8 * way.straight_usv
    assert min(math.hypot(*corner) for corner in corners) > 15.0
    assert '1 sources' in way.basis


def test_straight_way_over_one_source_has_the_dose_of_the_formula():
    """The integral of S / (h^2 + x^2) over a line, in closed form."""
    way = retreat(replace(DANGER, sources=(SOURCE,)))
    expected = 1e8 / HEIGHT_M * (math.atan(60.0 / 30.0) + math.atan(200.0 / 30.0)) / 5.0 / 3600.0
    assert way.straight_usv == pytest.approx(expected, rel=1e-3)


def test_without_sources_the_flown_way_is_taken_back():
    """What was flown is known; what lies beside it may be worse."""
    flown = ((-200.0, 160.0), (-100.0, 160.0), (0.0, 160.0), (60.0, 160.0))
    way = retreat(replace(DANGER, flown=flown, flown_usvh=(0.1, 0.1, 1.0, 1e5)))
    assert way.bends == flown[::-1]
    assert 'no source is found yet' in way.basis


def test_with_nothing_known_it_flies_straight():
    """The shortest time is the best guess."""
    assert retreat(DANGER).bends == ()


@pytest.mark.slow
@given(places, places, sources)
def test_no_way_has_a_higher_dose_than_the_straight_one(here, home, found):
    """The straight way is always among those that are compared."""
    danger = Danger(here_enu=(*here, HEIGHT_M), home=home, speed_mps=8.0, sources=found)
    way = retreat(danger)
    assert way.dose_usv <= 1.011 * way.straight_usv + 1e-9
    assert all(math.isfinite(value) for bend in way.bends for value in bend)


def test_exclusions_are_kept_on_the_way():
    """The way around a zone is longer than the straight one."""
    zone = ((-60.0, -50.0), (-40.0, -50.0), (-40.0, 50.0), (-60.0, 50.0))
    way = retreat(replace(DANGER, exclusions=(zone,), clearance_m=2.0))
    corners = [(60.0, 0.0), *way.bends, (-200.0, 0.0)]
    assert sum(math.dist(a, b) for a, b in pairwise(corners)) > 260.0
