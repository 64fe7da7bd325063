# SPDX-License-Identifier: Apache-2.0
"""Readers of numbers on a command line."""

from argparse import ArgumentTypeError

import pytest

from rocsafe_geo.argument import image_size, number, whole_number


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


@pytest.mark.parametrize('text', ['', '640', '640x', '640x480x3', 'axb', '640*480'])
def test_size_is_two_whole_numbers(text):
    """The error names the text and what it must be."""
    with pytest.raises(ArgumentTypeError, match='must be WxH, for instance 1280x800'):
        image_size(text)


@pytest.mark.parametrize('text', ['15x480', '640x8193', '-640x480'])
def test_size_is_within_limits(text):
    """An image of a million columns is refused before it is drawn."""
    with pytest.raises(ArgumentTypeError, match=f'^{text}: sides must be within 16 to 8192 px$'):
        image_size(text)
    assert image_size('16X8192') == (16, 8192)
