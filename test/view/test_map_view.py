# SPDX-License-Identifier: Apache-2.0
"""The map shows what it is given, where it is."""

import dataclasses
import html
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_view.map_marks import (
    Cordon,
    DosePoint,
    GasZone,
    PhotoPoint,
    ReleasePoint,
    ReplayTrack,
    SourcePoint,
)
from rocsafe_view.map_view import MapView
from rocsafe_view.pages import render
from rocsafe_view.palette import DoseScale, ramp_colour

SCALE = DoseScale(low_usvh=1.0, high_usvh=100.0)
SQUARE = ((0.0, 0.0), (100.0, 0.0), (100.0, 50.0), (0.0, 50.0))
EMPTY = MapView(
    origin_deg=(53.28, -9.06), metres_per_degree=(111_000.0, 66_000.0), vehicles=('rav1', 'rav2'),
    colours={'rav1': '#111111', 'rav2': '#222222'}, region=(SQUARE,), exclusions=(), routes={},
    planned={}, viewpoints={}, tracks={}, replay={}, readings=(), readings_per_point=1,
    has_radiation=True, photos=(),
    homes={}, sources=(), estimates=(), cordons=(), zones=(), releases=(), true_releases=(),
    replanned={}, picture=None,
)  # fmt: skip


def reading(x, time_s, dose_rate_usvh, vehicle='rav1'):
    """Return a reading on the line y = 0."""
    return DosePoint(x, 0.0, time_s, dose_rate_usvh, vehicle)


def with_readings(*readings):
    """Return a map of readings."""
    return dataclasses.replace(EMPTY, readings=readings)


def drawn(view):
    """Return the map as HTML."""
    return render('map.html', map=view, scale=SCALE)


@pytest.mark.slow
def test_map_of_gas_alone_shows_nothing_of_dose_rates():
    """And the true releases of the scenario, as others the true sources."""
    gas = dataclasses.replace(
        EMPTY, has_radiation=False, true_releases=(SourcePoint(50.0, 25.0, 'tanker'),)
    )
    page = drawn(gas)
    assert 'tanker (truth)' in page
    assert 'True releases (scenario)' in page
    for text in ('Dose', '>Radiation<', 'Cordons', 'True sources', 'Estimated sources'):
        assert text not in page, text
    assert 'True releases' not in drawn(EMPTY)
    assert 'Dose rate' in drawn(EMPTY)


def test_region_lies_in_view_with_a_margin():
    """The margin is 6 % of the longer side; homes far away are seen in `all` only."""
    view = dataclasses.replace(EMPTY, homes={'rav1': (-500.0, 0.0)})
    assert view.boxes['region'] == pytest.approx((-6.0, -6.0, 112.0, 62.0))
    assert view.boxes['all'][0] < -500.0


@pytest.mark.slow
@given(st.lists(st.tuples(st.floats(0.1, 1e4), st.floats(0.0, 5.0)), min_size=1, max_size=30))
def test_every_reading_is_drawn_once_as_part_of_a_line(rows):
    """Lines of one colour join at the middle between two readings, and none is lost."""
    time_s, readings = 0.0, []
    for index, (dose_rate, gap_s) in enumerate(rows):
        time_s += gap_s
        readings.append(reading(10.0 * index, time_s, dose_rate))
    strokes = with_readings(*readings).reading_strokes(SCALE)
    places = ' '.join(path for path, _ in strokes)
    assert all(re.search(rf'[ML]{10 * index} 0(?!\d)', places) for index in range(len(rows)))
    assert len({colour for _, colour in strokes}) == len(strokes)


def test_colour_changes_half_way_and_gaps_stay_open():
    """Readings of 1 and 100 uSv/h meet half-way; 10 s without a reading begin a new line."""
    view = with_readings(
        reading(0.0, 0.0, 1.0), reading(10.0, 1.0, 100.0), reading(50.0, 11.0, 100.0)
    )
    assert view.reading_strokes(SCALE) == [
        ('M0 0L5 0', ramp_colour(0.0)),
        ('M5 0L10 0M50 0h0', ramp_colour(1.0)),
    ]


def test_scale_is_made_of_what_was_measured_over_the_region():
    """Readings on the way there count only if there are no others."""
    inside, outside = reading(50.0, 0.0, 7.0), reading(900.0, 1.0, 3.0)
    assert with_readings(inside, outside).dose_rates_over_region() == [7.0]
    assert with_readings(outside).dose_rates_over_region() == [3.0]


@pytest.mark.slow
@pytest.mark.parametrize(('source_y', 'is_above'), [(20.0, True), (-20.0, False), (None, False)])
def test_highest_reading_is_named_away_from_the_nearest_source(source_y, is_above):
    """North of a source the name stands above, else below: south is down."""
    sources = () if source_y is None else (SourcePoint(50.0, source_y, 'capsule'),)
    view = dataclasses.replace(with_readings(reading(50.0, 0.0, 93.67)), sources=sources)
    page = drawn(view)
    y = float(re.search(r'label-middle" y="([-\d.]+)">highest 93.7', page)[1])
    assert (y < 0.0) == is_above


def test_names_are_escaped_everywhere():
    """A vehicle or a source may be called anything."""
    name = '<i>"x"'
    view = dataclasses.replace(
        EMPTY, vehicles=(name,), colours={name: '#123456'}, homes={name: (0.0, 0.0)},
        tracks={name: SQUARE}, routes={name: SQUARE}, viewpoints={name: SQUARE},
        planned={name: (SQUARE,)}, sources=(SourcePoint(0.0, 0.0, name),),
        replay={name: ReplayTrack(time_s=(0.0, 9.6), x=(0.0, 1.0), y=(0.0, 1.0))},
    )  # fmt: skip
    page = drawn(view)
    assert '<i>' not in page
    assert page.count(html.escape(name).replace('&quot;', '&#34;')) >= 6
    assert 'max="10"' in page


def test_labels_are_left_out_where_there_are_too_many_vehicles():
    """Ten names can be read, eleven cannot."""
    for count in (10, 11):
        names = [f'rav{number}' for number in range(count)]
        view = dataclasses.replace(
            EMPTY, colours=dict.fromkeys(names, '#000000'),
            homes=dict.fromkeys(names, (0.0, 0.0)), viewpoints=dict.fromkeys(names, SQUARE),
        )  # fmt: skip
        page = drawn(view)
        assert page.count('class="tag-text"') == page.count(' home<') == (10 if count == 10 else 0)


def test_script_is_given_indices_of_vehicles():
    """Readings and photographs name their vehicle by its place in the list."""
    photo = PhotoPoint(1.04, 2.0, 3.0, 'rav2-00001', 'rav2', 7, ((0.0, 0.0), (1.0, 0.25)))
    view = dataclasses.replace(with_readings(reading(1.0, 2.0, 93.67, 'rav2')), photos=(photo,))
    data = view.script_data()
    assert data['readings']['v'] == [1]
    assert data['highest'] == 0
    assert data['photos'] == {'rav2-00001': [1.0, 2.0, 3.0, 1, 7, '0.0,0.0 1.0,0.2']}


def square(x, side):
    """Return a ring about (x, 0)."""
    half = side / 2.0
    return ((x - half, -half), (x + half, -half), (x + half, half), (x - half, half))


def test_cordons_lie_on_the_map_with_their_radius():
    """Each part that is large enough is named at its northernmost point; all are listed."""
    one = Cordon(level_usvh=100.0, name='inner', parts=((square(0.0, 60.0),),))
    two = Cordon(
        level_usvh=25.0, name='outer', parts=((square(0.0, 80.0),), (square(200.0, 2.0),))
    )
    assert one.radius_text == '42\u00a0m'
    assert two.radius_text == '57\u00a0m (2 parts)'
    assert two.labels(20.0) == [((-40.0, -40.0), '25.0\u00a0µSv/h within 57\u00a0m')]
    page = drawn(dataclasses.replace(EMPTY, cordons=(two, one)))
    assert page.count('class="map-cordon"') == 2
    assert '100\u00a0µSv/h within 42\u00a0m</text>' in page
    listed = page[page.index('cordons-listed') :]
    assert listed.index('100\u00a0µSv/h') < listed.index('25.0\u00a0µSv/h')


def test_what_a_run_lacks_cannot_be_switched_on():
    """Without cordons and further plans their switches are off and say so."""
    assert 'Routes planned in flight (none)' in drawn(EMPTY)
    assert 'Cordons, upper 95 % (none)' in drawn(EMPTY)


def zone(number, side_m, **changed):
    """Return a square zone about the origin."""
    ring = ((0.0, 0.0), (side_m, 0.0), (side_m, -side_m), (0.0, -side_m))
    return GasZone(**{
        'level': f'AEGL-{number}', 'number': number, 'agent': 'ammonia', 'ppm': 160.0,
        'minutes': 60.0, 'expected': (), 'outer': (ring,), 'is_cut': False, 'reach_m': 212.0,
        'reach_deg': 44.0,
    } | changed)  # fmt: skip


def test_threat_zones_lie_over_the_photographs_below_the_tracks():
    """Each with its level; where they reach is listed, the highest level first."""
    view = dataclasses.replace(
        EMPTY, zones=(zone(1, 400.0, is_cut=True), zone(2, 150.0)),
        releases=(ReleasePoint(x=1.0, y=2.0, radius_m=9.0),),
    )  # fmt: skip
    page = drawn(view)
    assert page.index('data-layer="ground"') < page.index('gas-zone gas-zone-1')
    assert page.index('gas-zone gas-zone-2') < page.index('data-layer="tracks"')
    assert 'ammonia, AEGL-2: 160 ppm over 60 minutes, outer bound 95 %' in page
    listed = re.findall(r'(AEGL-\d)</span><span>([^<]*)<', page)
    assert [name for name, _ in listed] == ['AEGL-2', 'AEGL-1']
    assert [text.replace('\u202f', ' ').replace('\xa0', ' ') for _, text in listed] == [
        '210 m to the NE', 'at least 210 m to the NE',
    ]  # fmt: skip
    assert 'release 1 (estimated)' in page


def test_all_that_was_found_can_be_brought_into_view():
    """Threat zones end far from the region."""
    view = dataclasses.replace(EMPTY, zones=(zone(1, 400.0),))
    assert view.boxes['all'][2] > 400.0
    assert view.boxes['region'] == EMPTY.boxes['region']
    assert 'Gas</button>' not in drawn(EMPTY)
