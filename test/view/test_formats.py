# SPDX-License-Identifier: Apache-2.0
"""Quantities as people read them, and colours as they see them."""

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rocsafe_view import formats
from rocsafe_view.palette import (
    VEHICLE_COLOURS,
    DoseScale,
    ramp_colour,
    scale_of,
    vehicle_colours,
)

rates = st.floats(min_value=1e-9, max_value=1e12)


def plain(text):
    """Return `text` with ordinary spaces."""
    return text.replace('\u00a0', ' ').replace('\u202f', ' ')


@pytest.mark.parametrize(
    ('value', 'text'),
    [
        (0.0, '0'),
        (0.9999, '1.00'),
        (9.996, '10.0'),
        (93.67, '93.7'),
        (12345.6, '12 300'),
        (0.01234, '0.0123'),
        (math.nan, '–'),
    ],
)
def test_three_figures(value, text):
    """Three significant figures, thousands apart, never in powers of ten."""
    assert plain(formats.figures(value)) == text


@pytest.mark.parametrize(
    ('hours', 'text'),
    [
        (0.01, '36 s'), (0.2, '12 min'), (1.0, '1 h'), (20.0, '20 h'), (40.0, '40 h'),
        (200.0, '8.3 d'), (8000.0, '330 d'), (1e6, 'over 10 years'), (math.inf, 'over 10 years'),
    ],
)  # fmt: skip
def test_stay_times_can_be_read(hours, text):
    """Never 8e+03 h, never more figures than are known."""
    assert plain(formats.stay(hours)) == text


@given(st.floats(0.0, 1.0))
@example(0.99609375)
def test_what_is_not_certain_is_not_shown_as_certain(share):
    """Neither 100 % nor 0 %."""
    text = plain(formats.probability(share))
    assert text not in ('100 %', '0 %')


@pytest.mark.parametrize(
    ('value', 'text'),
    [
        (93.67, '93.7 µSv/h'),
        (90_000.0, '90.0 mSv/h'),
        (2.5e6, '2.50 Sv/h'),
        (0.43, '0.43 µSv/h'),
        (1e-5, '< 0.001 µSv/h'),
        (None, '–'),
    ],
)
def test_dose_rates_have_a_fitting_unit(value, text):
    """Micro, milli or whole sievert an hour."""
    assert plain(formats.spaced(formats.dose_rate(value))) == text


@pytest.mark.parametrize(
    ('value', 'text'),
    [(42.04, '42.0 s'), (59.96, '1 min 00 s'), (371.2, '6 min 11 s'), (3725.0, '1 h 02 min'),
     (None, '–')],
)  # fmt: skip
def test_durations(value, text):
    """No duration reads 60 seconds or 60 minutes."""
    assert plain(formats.duration(value)) == text


def test_clock_shows_hours_when_there_are_any():
    """Minutes and seconds, hours only when needed; rounded as a page in a browser rounds."""
    assert [formats.clock(s) for s in (0.0, 59.4, 59.6, 3599.0, 3600.0, 3966.0)] == [
        '00:00',
        '00:59',
        '01:00',
        '59:59',
        '1:00:00',
        '1:06:06',
    ]


def test_what_is_not_quite_all_is_not_100_percent():
    """Nobody shall read complete where something is missing."""
    assert plain(formats.percent(1.0)) == '100 %'
    assert plain(formats.percent(0.99999)) == '99.9 %'
    assert plain(formats.percent(0.5)) == '50.0 %'


@given(st.floats(min_value=0.0, max_value=10.0))
def test_limits_are_rounded_up(fraction):
    """At most 27.4 % stays true."""
    shown = float(formats.upper_percent(fraction).split('\u00a0')[0]) / 100.0
    assert fraction - 1e-8 <= shown <= fraction + 0.0011


def test_positions_name_their_hemisphere():
    """All four quadrants."""
    assert plain(formats.latitude_longitude(53.27985, -9.0633)) == '53.27985° N, 9.06330° W'
    assert plain(formats.latitude_longitude(-33.5, 151.25)) == '33.50000° S, 151.25000° E'


def test_lists_read_as_sentences():
    """Commas, then and."""
    assert formats.sentence_list(['a', 'b', 'c']) == 'a, b and c'
    assert formats.sentence_list(['a']) == 'a'
    assert formats.sentence_list([]) == ''


def test_areas_lengths_and_sizes_choose_their_unit():
    """Square metres or hectares, metres or kilometres, bytes to megabytes."""
    assert plain(formats.area(20171.6)) == '2.02 ha'
    assert plain(formats.area(950.4)) == '950 m²'
    assert plain(formats.length(1891.1)) == '1 891 m'
    assert plain(formats.length(12_345.0)) == '12.3 km'
    assert plain(formats.size(13_900_000)) == '13.9 MB'


@given(st.lists(rates, min_size=1))
def test_scale_holds_what_it_was_made_of(values):
    """The highest lies on it; its ends are round and at least a decade apart."""
    scale = scale_of(values)
    assert max(values) <= scale.high_usvh * (1 + 1e-9)
    assert scale.high_usvh / scale.low_usvh >= 9.99
    assert scale.high_usvh / scale.low_usvh <= 1.1e5


@given(rates, rates)
def test_higher_rates_never_have_lower_colours(one, other):
    """The scale is monotonic."""
    scale = DoseScale(low_usvh=0.1, high_usvh=100.0)
    low, high = sorted((one, other))
    assert scale.fraction(low) <= scale.fraction(high)


def test_scale_is_logarithmic():
    """Half-way between 1 and 100 is 10."""
    assert DoseScale(low_usvh=1.0, high_usvh=100.0).fraction(10.0) == pytest.approx(0.5)
    assert DoseScale(low_usvh=1.0, high_usvh=1e4).ticks() == [1.0, 10.0, 100.0, 1e3, 1e4]


def test_tail_of_low_rates_may_lie_below_the_scale():
    """A few readings on the way home do not flatten the colours over the region."""
    values = [0.05] * 2 + [20.0 + n for n in range(98)]
    assert scale_of(values).low_usvh == 0.05
    assert scale_of(values, tail=0.05).low_usvh == 20.0


def test_nothing_measured_still_has_a_scale():
    """An empty legend is better than none."""
    assert scale_of([]).low_usvh < scale_of([]).high_usvh
    assert scale_of([0.0, math.nan]) == scale_of([])


@pytest.mark.parametrize(('low', 'high'), [(0.0, 1.0), (2.0, 1.0), (1.0, math.inf)])
def test_scale_without_extent_is_refused(low, high):
    """The error names the ends."""
    with pytest.raises(ValueError, match='low_usvh'):
        DoseScale(low_usvh=low, high_usvh=high)


def test_lightness_of_the_ramp_only_grows():
    """Read without colour, brighter is more."""

    def lightness(fraction):
        red, green, blue = (int(ramp_colour(fraction)[i : i + 2], 16) for i in (1, 3, 5))
        return 0.2126 * red + 0.7152 * green + 0.0722 * blue

    shades = [lightness(number / 50) for number in range(51)]
    assert shades == sorted(shades)


def test_each_vehicle_has_a_colour():
    """Beyond the set colours repeat rather than run out."""
    colours = vehicle_colours([f'rav{n}' for n in range(20)])
    assert len(colours) == 20
    assert len(set(list(colours.values())[:8])) == 8


# How colours look to people, linear sRGB (Machado, Oliveira and Fernandes, 2009, severity 1).
SEEN_BY = {
    'most people': np.eye(3),
    'protanopes': np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216],
                            [-0.003882, -0.048116, 1.051998]]),
    'deuteranopes': np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413],
                              [-0.011820, 0.042940, 0.968881]]),
    'tritanopes': np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602],
                            [0.004733, 0.691367, 0.303900]]),
}  # fmt: skip


def linear(colour: str) -> np.ndarray:
    """Return a colour ``#rrggbb`` as linear sRGB."""
    shares = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)]) / 255.0
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def lab(colour: np.ndarray) -> np.ndarray:
    """Return a colour of linear sRGB in CIELAB, white of D65."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722],
                       [0.0193, 0.1192, 0.9505]])  # fmt: skip
    share = to_xyz @ np.clip(colour, 0.0, 1.0) / (0.9505, 1.0, 1.089)
    x, y, z = np.where(share > 0.008856, np.cbrt(share), 7.787 * share + 16.0 / 116.0)
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


@pytest.mark.parametrize('people', SEEN_BY)
def test_vehicles_are_told_apart_by_their_colours(people):
    """Two of the former colours were 3 apart to deuteranopes; 2 is the least to be seen."""
    seen = [lab(SEEN_BY[people] @ linear(one)) for one in VEHICLE_COLOURS]
    assert min(math.dist(a, b) for a, b in combinations(seen, 2)) >= 20.0


@pytest.mark.parametrize('ground', ['#ffffff', '#14191a'])
def test_vehicles_are_seen_on_light_and_dark_ground(ground):
    """The contrast is that of WCAG 2."""
    weights = (0.2126, 0.7152, 0.0722)
    lights = [float(weights @ linear(colour)) + 0.05 for colour in (ground, *VEHICLE_COLOURS)]
    assert min(max(lights[0] / one, one / lights[0]) for one in lights[1:]) >= 2.3


def test_units_of_gas_sensors_are_written_as_people_do() -> None:
    """A sum along a path is no quotient."""
    units = [formats.gas_unit(unit) for unit in ('ppm', 'mg_m3', 'ppm_m')]
    assert units == ['ppm', 'mg/m³', 'ppm m']
