# SPDX-License-Identifier: Apache-2.0
"""Policies to compare with: the informed ones need fewer readings than the lawn-mower."""

import numpy as np
import pytest

from rocsafe_learning.policies.policies import (
    FEATURES,
    LinearPolicy,
    at_random,
    information_gain,
    lawn_mower,
)
from rocsafe_learning.scores import score
from rocsafe_learning.source_search import SearchOptions, SourceSearch

SEEDS = range(500, 520)


def test_lawn_mower_covers_the_area_lane_by_lane():
    """Neighbours in the row are one lane apart, and every place is visited once in a round."""
    search, policy = SourceSearch(SearchOptions()), lawn_mower(100.0, lanes=4)
    places = [policy(search) for _ in range(16)]
    assert len(set(places)) == 16
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert steps == pytest.approx(np.full(15, 25.0))


@pytest.mark.slow
def test_information_saves_a_fifth_of_the_readings():
    """On the same searches; and finds the source at least as often."""
    options = SearchOptions()
    plain = score(lambda: lawn_mower(options.area_m), SEEDS, options)
    informed = score(lambda: information_gain(options.area_m), SEEDS, options)
    assert informed.readings <= 0.8 * plain.readings
    assert informed.found_share >= plain.found_share


def test_linear_policy_follows_its_weights():
    """Weighted by time alone it stays where it is nearest to."""
    search = SourceSearch(SearchOptions())
    search.begin(np.random.default_rng(1))
    stay = LinearPolicy(np.array([0.0, -1.0, 0.0, 0.0]))
    assert len(FEATURES) == 4
    assert stay(search) == (6.25, 6.25)
    go = LinearPolicy(np.array([0.0, 1.0, 0.0, 0.0]))
    assert go(search) == (93.75, 93.75)


@pytest.mark.slow
def test_the_same_searches_give_the_same_score():
    """Scores depend on nothing but seeds and options."""
    options = SearchOptions(readings=5)
    one, two = (
        score(lambda: at_random(100.0, np.random.default_rng(2)), range(4), options)
        for _ in range(2)
    )
    assert one == two
