# SPDX-License-Identifier: Apache-2.0
"""Places whose readings tell most, against the determinants that define information."""

import itertools
import math

import numpy as np
import pytest
import shapely

from rocsafe_hazard.next_places import are_within, next_places

NOISE = 0.3


def information(factor, chosen):
    """Return 1/2 log det(1 + covariance / noise) of readings at some places, nats."""
    own = factor[:, list(chosen)]
    return 0.5 * np.linalg.slogdet(np.eye(len(chosen)) + own.T @ own / NOISE)[1]


def test_gains_add_up_to_the_information_of_all():
    """And each is the largest that is left."""
    factor = np.random.default_rng(1).standard_normal((3, 12))
    places = np.arange(36.0).reshape(12, 3)
    chosen = next_places(places, factor, NOISE, 4)
    numbers = [int(one.place_m[0] / 3.0) for one in chosen]
    assert len(set(numbers)) == 4
    assert math.fsum(one.gain for one in chosen) == pytest.approx(information(factor, numbers))
    for count in range(4):
        before, others = numbers[:count], set(range(12)) - set(numbers[:count])
        best = max(others, key=lambda one: information(factor, [*before, one]))
        assert numbers[count] == best
    pairs = itertools.combinations(range(12), 2)
    assert information(factor, numbers[:2]) > 0.6 * max(information(factor, two) for two in pairs)


def test_nothing_is_asked_where_all_is_known():
    """Of equal predictions no reading tells anything."""
    assert next_places(np.zeros((5, 3)), np.zeros((2, 5)), NOISE, 3) == []


def test_places_within_an_area():
    """Without an area, all are."""
    places = np.array([[0.0, 0.0, 9.0], [2.0, 0.0, 9.0]])
    assert are_within(places, None).all()
    assert are_within(places, shapely.box(-1.0, -1.0, 1.0, 1.0)).tolist() == [True, False]
