# SPDX-License-Identifier: Apache-2.0
"""Readers of numbers on a command line."""

from argparse import ArgumentTypeError

import pytest

from rocsafe_geo.argument import number, whole_number


@pytest.mark.parametrize('text', ['nan', '', 'x', '1.5', '-0.1', 'inf'])
def test_number_out_of_limits_is_refused_by_value(text):
    """The error names value, limits and unit."""
    with pytest.raises(ArgumentTypeError, match=f'^{text}: must be within 0 to 1 m$'):
        number(0.0, 1.0, ' m')(text)


def test_limits_are_allowed():
    """Both ends belong to the range."""
    assert [number(0.0, 1.0)(text) for text in ('0', '1', '1e-1')] == [0.0, 1.0, 0.1]
    assert [whole_number(2, 4)(text) for text in ('2', '4')] == [2, 4]


@pytest.mark.parametrize('text', ['1', '5', '2.0', '-2', '٣', ''])
def test_whole_number_is_ascii_digits_within_limits(text):
    """Signs, points and digits of other scripts are refused."""
    with pytest.raises(ArgumentTypeError, match='must be a whole number, 2 to 4'):
        whole_number(2, 4)(text)
