# SPDX-License-Identifier: Apache-2.0
"""A place that is typed: what the console tells in any form, it reads in this form."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_console.picture.coordinates import coordinates_of
from rocsafe_console.picture.places import place_of_text

M_PER_DEG = 111_320.0


def metres(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Return the distance of two places that are close."""
    east = math.remainder(b[1] - a[1], 360.0) * math.cos(math.radians(a[0]))
    return math.hypot(b[0] - a[0], east) * M_PER_DEG


@given(
    latitude=st.floats(-79.9, 83.9, allow_nan=False),
    longitude=st.floats(-179.99, 179.99, allow_nan=False),
)
def test_each_form_is_read_as_the_place_that_it_was_told_for(latitude, longitude):
    """To the metre that a form has; MGRS and UTM are cut off below it."""
    forms = coordinates_of(latitude, longitude)
    for text, limit_m in (
        (forms.decimal, 0.2), (forms.dms, 0.4), (forms.mgrs, 1.6), (forms.utm, 1.6),
        (forms.mgrs.replace(' ', ''), 1.6), (forms.mgrs.lower(), 1.6),
    ):  # fmt: skip
        assert metres(place_of_text(text), (latitude, longitude)) < limit_m, text


@pytest.mark.parametrize(
    ('text', 'place'),
    [
        ('53.28, -9.0633', (53.28, -9.0633)),
        (' 53.28 -9.0633 ', (53.28, -9.0633)),
        ('53.28N 9.0633W', (53.28, -9.0633)),
        ('33.5 s; 70 w', (-33.5, -70.0)),
        ('53 16 48 N, 9 03 48 W', (53.28, -9.063333)),
        ('53°16\'48"N 9°3\'48"W', (53.28, -9.063333)),
        ("53°16.8'N 9°3.8'W", (53.28, -9.063333)),
        ('N53 16.800 W009 03.800', (53.28, -9.063333)),
        ('S 33.5, W 70', (-33.5, -70.0)),
        ('29N 495777 5903420', (53.28, -9.063333)),
        # Maps of zone 29 are printed a little into zone 28.
        ('29U 295000 5911000', (53.30845, -12.07706)),
    ],
)
def test_forms_that_people_write(text, place):
    """With signs, letters, spaces or marks."""
    assert metres(place_of_text(text), place) < 5.0


@pytest.mark.parametrize(
    'text',
    ['', 'Galway', '53.28', '91, 0', '53, 181', '61U MV 1 1', '29U MV 123 1', '29U AA 11 11',
     '29I MV 11 11', '1' * 500, "53°16'48\" 9°3'48\"", '<b>', 'nan, nan', '1e400, 1', '53,28',
     "53°75'N 9°W", '53 16 99 N 9 3 48 W', '29U JV 12345 12345', '29C 512345 5903560',
     '29U 999999 9999999', '29S 495777 5903420', '31X AA 1 1'],
)  # fmt: skip
def test_what_is_no_place_is_refused(text):
    """In one line."""
    with pytest.raises(ValueError, match=r'place|latitude|zone|MGRS|UTM|below 60') as caught:
        place_of_text(text)
    assert '\n' not in str(caught.value)
