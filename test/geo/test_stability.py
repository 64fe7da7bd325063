# SPDX-License-Identifier: Apache-2.0
"""Stability classes, Obukhov lengths and the curves of Briggs against published values."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_dispersion.plume.briggs import briggs_sigmas_m
from rocsafe_geo.wind.stability import (
    CLASSES,
    class_of_length,
    layer_of_class,
    obukhov_length_m,
)


@given(st.sampled_from(CLASSES), st.floats(0.005, 0.5))
def test_class_of_its_own_length(stability, roughness):
    """A class comes back from its Obukhov length."""
    assert class_of_length(obukhov_length_m(stability, roughness), roughness) == stability


def test_lengths_have_the_sign_of_their_class():
    """Unstable below 0, neutral infinite, stable above 0; known value of Golder for 0.1 m."""
    lengths = [obukhov_length_m(one, 0.1) for one in CLASSES]
    assert max(lengths[:3]) < 0.0 < min(lengths[4:])
    assert math.isinf(lengths[3])
    assert lengths[0] == pytest.approx(-8.0)


def test_layer_of_a_class():
    """It has the wind that was given."""
    assert float(layer_of_class('F', 2.0, 10.0, 0.05).speed_mps(10.0)) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ('stability', 'across', 'upwards'),
    [('A', 209.8, 200.0), ('C', 104.9, 73.0), ('D', 76.3, 37.9), ('F', 38.1, 12.3)],
)
def test_curves_of_briggs_at_1000_m(stability, across, upwards):
    """Rural."""
    found = briggs_sigmas_m(1000.0, stability)
    assert np.allclose(found, (across, upwards), atol=0.06)


@pytest.mark.parametrize(
    'make',
    [
        lambda: obukhov_length_m('G', 0.1),
        lambda: obukhov_length_m('D', 3.0),
        lambda: briggs_sigmas_m(10.0, 'D', 'lunar'),
    ],
)
def test_bad_values_are_refused(make):
    """With one error type."""
    with pytest.raises(ValueError, match=r'must|no curves'):
        make()
