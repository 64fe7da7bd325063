# SPDX-License-Identifier: Apache-2.0
"""Anyone's file of readings is read or refused in one line, and its sources are told."""

import itertools
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
import rasterio

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.command_line.file_survey import file_survey
from rocsafe_radiation.command_line.localize_arguments import parser
from rocsafe_radiation.command_line.localize_command import main
from rocsafe_radiation.readings.readings_file import ReadingsFileError, read_readings
from rocsafe_radiation.readings.survey import survey_of

from .simulated_survey import survey

ORIGIN = GeoPosition(53.28, -9.06, 66.0)
HEAD = 'time_ns,vehicle,latitude_deg,longitude_deg,altitude_m,dose_rate_usvh\n'


@pytest.fixture
def table(tmp_path):
    """Give a function that writes a file."""

    def write(text):
        path = tmp_path / 'readings.csv'
        path.write_text(text, encoding='utf-8')
        return path

    return write


@pytest.fixture(autouse=True)
def _small_maps(monkeypatch):
    """Maps of fewer cells are made faster."""
    monkeypatch.setattr('rocsafe_radiation.command_line.localize_command.LARGEST_CELLS', 10_000)


def derailment():
    """Return rows of a survey over a source at 120 m east, 170 m north of the origin."""
    readings = survey([(120.0, 170.0, 9250.0)])
    places = LocalFrame(ORIGIN).to_geodetic(readings.positions_enu_m)
    rates = readings.counts / readings.exposures
    ground = '0,rav1,53.28,-9.06,66.0,0.1\n'
    return ground + ''.join(
        f'{number + 1},rav1,{lat!r},{lon!r},{alt!r},{rate!r}\n'
        for number, ((lat, lon, alt), rate) in enumerate(
            zip(places.tolist(), rates.tolist(), strict=True)
        )
    )


@pytest.mark.slow
def test_a_source_is_printed_with_its_place_and_its_ellipse(table, capsys):
    """In degrees, on the ground below the lowest reading."""
    assert main([str(table(HEAD + derailment())), '--model', 'paper', '--json']) == 0
    document = json.loads(capsys.readouterr().out)
    (source,) = document['sources']
    place = source['place']
    found = LocalFrame(ORIGIN).enu_of(
        GeoPosition(place['latitude_deg'], place['longitude_deg'], place['altitude_m'])
    )
    assert math.hypot(found[0] - 120.0, found[1] - 170.0) < 2.0
    assert source['dose_rate_at_1m_usvh'] == pytest.approx(9250.0, rel=0.1)


@pytest.mark.slow
def test_a_guessed_ground_is_told_and_a_given_one_is_taken(table, capsys):
    """A flight that does not begin on the ground needs its altitude: it is refused."""
    path = str(table(HEAD + ''.join(derailment().splitlines(keepends=True)[1:])))
    assert main([path, '--model', 'paper', '--ground', '66']) == 0
    text = capsys.readouterr().out
    assert 'source 1: ' in text
    assert 'the ground is not given' not in text
    assert main([path, '--model', 'paper']) == 2
    assert 'the ground is not known' in capsys.readouterr().err
    readings = read_readings(Path(path))
    assert readings.is_ground_guessed
    assert readings.frame.origin.altitude_m == pytest.approx(98.0, abs=0.1)
    assert not read_readings(Path(path), ground_altitude_m=66.0).is_ground_guessed


def test_errors_of_altitudes_are_no_take_off_and_readings_are_above_the_ground(table, capsys):
    """1.5 m of them, and a ground 100 m too high."""
    ups = np.random.default_rng(1).normal(98.0, 1.5, 500)
    rows = ''.join(f'{k},rav1,53.28,-9.{k:04d},{up:.2f},0.1\n' for k, up in enumerate(ups, 1000))
    path = str(table(HEAD + rows))
    assert main([path]) == 2
    assert 'show a take-off' in capsys.readouterr().err
    assert main([path, '--ground', '200']) == 2
    assert 'below the ground: must be above' in capsys.readouterr().err


def test_a_file_without_altitudes_was_flown_above_the_ground_not_on_it(table):
    """All readings are as high as `--height` says."""
    text = 'latitude_deg,longitude_deg,dose_rate_usvh\n53.28,-9.06,0.1\n53.281,-9.06,0.1\n'
    found = read_readings(table(text), 32.0)
    assert [one.position_enu_m[2] for one in found.observations] == pytest.approx(
        [32.0, 32.0], abs=0.01
    )


@pytest.mark.slow
def test_products_are_written(table, tmp_path, capsys):
    """A GeoJSON point and a closed ring around it."""
    assert main([str(table(HEAD + derailment())), '--out', str(tmp_path / 'out')]) == 0
    assert 'source 1: latitude_deg 53.28' in capsys.readouterr().out
    shapes = json.loads((tmp_path / 'out' / 'sources.geojson').read_text())
    point, ellipse = (feature['geometry'] for feature in shapes['features'])
    ring = ellipse['coordinates'][0]
    assert point['type'] == 'Point'
    assert ring[0] == ring[-1]
    area = sum(a[0] * b[1] - b[0] * a[1] for a, b in itertools.pairwise(ring))
    assert area > 0.0, 'rings run anticlockwise'


def test_bad_rows_are_left_out_and_counted(table):
    """NaN, words, impossible places, negative values and repeated stamps; clock jumps are kept."""
    rows = (
        '1,a,53.0,-9.0,60.0,0.1\n2,a,nan,-9.0,60.0,0.1\n3,a,53.0,-9.0,60.0,high\n'
        '4,a,93.0,-9.0,60.0,0.1\n5,a,53.0,-9.0,60.0,-0.1\n1,a,53.0,-9.0,60.0,0.1\n'
        '1,b,53.0,-9.0,60.0,0.1\n9,a,53.0,-9.0,60.0,0.1\n6,a,53.0,-9.0,60.0,0.1\n'
    )
    readings = read_readings(table(HEAD + rows))
    assert len(readings.observations) == 4
    assert sorted(readings.dropped.values()) == [(3, 4), (5,), (6,), (7,)]
    assert readings.backward_steps == 1


@pytest.mark.parametrize(
    ('head', 'words'),
    [
        ('a,b\n', 'has no columns latitude_deg and longitude_deg'),
        ('latitude_deg,longitude_deg,dose_rate_usvh\n', 'has no column altitude_m'),
        ('east_m,north_m,up_m\n', 'has no column dose_rate_usvh, nor counts'),
        ('east_m,north_m,up_m,counts\n', 'has no column dose_rate_usvh, nor counts'),
        (
            'east_m,north_m,up_m,dose_rate_usvh,dose_rate_svh\n',
            'several units, dose_rate_svh and dose_rate_usvh',
        ),
        ('', 'has no columns latitude_deg'),
    ],
)
def test_a_file_that_is_no_survey_is_refused_in_one_line(table, head, words, capsys):
    """Saying what is missing."""
    path = table(head + '1,2,3,4,5\n')
    if head:
        with pytest.raises(ReadingsFileError, match=words):
            read_readings(path)
    assert main([str(path)]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_units_are_those_of_the_column(table):
    """Sievert, microsievert a second."""
    for name, value in (('svh', '1e-6'), ('nsvh', '1000'), ('usvps', repr(1 / 3600))):
        readings = read_readings(table(f'east_m,north_m,up_m,dose_rate_{name}\n1,2,3,{value}\n'))
        assert readings.observations[0].dose_rate_usvh == pytest.approx(1.0)


def test_no_file_is_one_line(tmp_path, capsys):
    """With its name."""
    assert main([str(tmp_path / 'none.csv')]) == 2
    assert 'none.csv: cannot be read' in capsys.readouterr().err


def test_counts_of_a_reference_window_are_read_with_their_rows(table):
    """A row without one is left out, like any without a number."""
    text = 'east_m,north_m,up_m,counts,live_time_s,reference_counts\n1,2,3,9,1,4\n1,2,3,9,1,\n'
    readings = read_readings(table(text))
    assert readings.reference_counts == (4.0,)
    assert list(readings.dropped.values()) == [(3,)]


@pytest.mark.slow
def test_the_next_places_are_told(table, capsys):
    """As many as wanted, around the source, and whether the evidence is enough."""
    assert main([str(table(HEAD + derailment())), '--next', '3', '--ground', '66']) == 0
    text = capsys.readouterr().out
    places = {line for line in text.splitlines() if 'measure next at latitude_deg 53.28' in line}
    assert len(places) == 3
    assert 'the evidence is enough: 1 source, placed within ' in text


def test_the_grid_of_beliefs_is_a_method_by_name(table, capsys):
    """Same file, same document, a rougher place."""
    path = str(table(HEAD + derailment()))
    assert main([path, '--method', 'belief-grid', '--json']) == 0
    document = json.loads(capsys.readouterr().out)
    assert document['method'] == 'belief-grid'
    (source,) = document['sources']
    place = GeoPosition(**source['place'])
    found = LocalFrame(ORIGIN).enu_of(place)
    assert math.hypot(found[0] - 120.0, found[1] - 170.0) < 20.0
    assert document['false_alarm_probability'] == 0.01


def test_a_wrong_rate_of_errors_is_refused(table, capsys):
    """With its limit."""
    with pytest.raises(SystemExit):
        main([str(table(HEAD)), '--errors', '0.7'])
    assert 'argument --errors: 0.7: must be within 1e-06 to 0.49' in capsys.readouterr().err


def test_saturated_readings_are_left_out_and_counted(table):
    """What they say is only a lower limit."""
    head = 'east_m,north_m,up_m,dose_rate_usvh,saturated\n'
    readings = read_readings(table(head + '1,2,3,9,0\n1,2,3,9,1\n1,2,3,9,\n'))
    assert len(readings.observations) == 2
    assert readings.dropped == {'saturated: the dose rate is only a lower limit': (3,)}


@pytest.mark.slow
def test_a_ground_that_nobody_gave_is_told_in_every_product_and_is_never_enough(
    table, tmp_path, capsys
):
    """The file begins with a take-off, which is no proof of the ground below the sources."""
    out = tmp_path / 'out'
    assert main([str(table(HEAD + derailment())), '--json', '--out', str(out)]) == 0
    printed = json.loads(capsys.readouterr().out)
    written = json.loads((out / 'sources.json').read_text())
    cordons = json.loads((out / 'cordons.geojson').read_text())['features']
    sources = json.loads((out / 'sources.geojson').read_text())
    with rasterio.open(out / 'dose_map.tif') as raster:
        tags = raster.tags()
    for doubts in (
        printed['doubts'],
        written['doubts'],
        sources['doubts'],
        cordons[0]['properties']['doubts'],
        [tags['DOUBTS']],
        [(out / 'cordons.kml').read_text(encoding='utf-8')],
    ):
        assert any('the ground is not given' in doubt for doubt in doubts)
    assert not printed['is_enough']
    assert not written['is_enough']


ROW = '{},rav1,53.28{:02d},-9.06,98.0,0.1\n'


@pytest.mark.parametrize(
    ('bad', 'words'),
    [
        ('50,rav1,0.0,0.0,98.0,0.1\n', 'at 0, 0'),
        ('50,rav1,53.9,-9.06,98.0,0.1\n', 'farther than 1 km'),
        ('50,rav1,53.33,-9.06,98.0,0.1\n', 'farther than 1 km'),
        ('50,rav1,53.28,-9.06,98.0,1e300\n', 'dose_rate_usvh is not within'),
        ('50,rav1,53.28,-9.06,1e300,0.1\n', 'altitude_m is not within'),
        (HEAD, 'the names of the columns again'),
        ('50,rav1,53,28,-9,06,98.0,0.1\n', 'decimal commas'),
    ],
)
def test_rows_that_cannot_be_are_left_out_and_named_by_line(table, bad, words):
    """The tenth row is line 11."""
    good = [ROW.format(number, number) for number in range(20)]
    readings = read_readings(table(HEAD + ''.join([*good[:9], bad, *good[9:]])))
    ((reason, lines),) = readings.dropped.items()
    assert words in reason
    assert lines == (11,)
    assert len(readings.observations) == 20


def test_a_detector_that_counts_nothing_is_dead(table, capsys):
    """Its rows prove no absence; a whole file of them is refused."""
    head = 'vehicle,east_m,north_m,up_m,counts,live_time_s\n'
    dead = ''.join(f'b,{number},0,30,0,1\n' for number in range(0, 200, 10))
    alive = ''.join(f'a,{number},0,30,{number % 3},1\n' for number in range(20))
    readings = read_readings(table(head + alive + dead))
    assert len(readings.observations) == 20
    ((reason, lines),) = readings.dropped.items()
    assert 'dead' in reason
    assert lines == tuple(range(22, 42))
    assert main([str(table(head + dead)), '--sensitivity', '550']) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_detector_that_dies_in_flight_is_dead_from_then_on(table):
    """Few counts are none: a detector that counts 0 or 1 lives."""
    head = 'vehicle,east_m,north_m,up_m,counts,live_time_s\n'
    dies = ''.join(
        f'a,{number},0,30,{(50 + number % 7) * (number < 30)},1\n' for number in range(60)
    )
    weak = ''.join(f'b,{number},0,30,{int(number % 20 == 0)},1\n' for number in range(60))
    readings = read_readings(table(head + dies + weak))
    ((reason, lines),) = readings.dropped.items()
    assert 'dead' in reason
    assert lines == tuple(range(32, 62))


def test_dose_rates_in_another_unit_than_their_counts_are_left_out(table):
    """Each third row is in nSv/h in a column of uSv/h."""
    head = 'east_m,north_m,up_m,dose_rate_usvh,counts,live_time_s\n'
    rows = ''.join(f'{k},0,30,{100 if k % 3 == 0 else 0.1},{52 + k % 7},1\n' for k in range(30))
    readings = read_readings(table(head + rows))
    ((reason, lines),) = readings.dropped.items()
    assert 'another unit' in reason
    assert lines == tuple(range(2, 32, 3))


@pytest.mark.parametrize(
    ('rates', 'is_refused'),
    [
        pytest.param([100 if k % 3 == 0 else 0.1 for k in range(60)], True, id='each third row'),
        pytest.param([100 if k >= 40 else 0.1 for k in range(60)], True, id='from one row on'),
        pytest.param([100 if k % 2 else 0.1 for k in range(60)], True, id='each second row'),
        pytest.param([0.1 + 4600 / (1 + (k - 30) ** 2) for k in range(60)], False, id='source'),
        pytest.param([4600 if k in (20, 40) else 0.1 for k in range(60)], False, id='few'),
    ],
)
def test_several_units_in_one_column_are_refused_and_sources_are_not(table, rates, is_refused):
    """Dose rates beside a source rise over some readings; single ones may be strong sources."""
    rows = ''.join(f'{k},0,1,{rate}\n' for k, rate in enumerate(rates))
    path = table('east_m,north_m,up_m,dose_rate_usvh\n' + rows)
    if is_refused:
        with pytest.raises(ReadingsFileError, match=r'several units in one column'):
            read_readings(path)
    else:
        assert len(read_readings(path).observations) == 60


def test_quoted_decimal_commas_are_read(table):
    """A comma within a cell separates no columns."""
    path = table('east_m,north_m,up_m,dose_rate_usvh\n"1,5","2","30,25","0,1"\n')
    (one,) = read_readings(path).observations
    assert one.position_enu_m == (1.5, 2.0, 30.25)


def test_a_refusal_names_the_rows_left_out(table, capsys):
    """Else a file of bad rows is only too small."""
    rows = ''.join(f'{k},rav1,53,28,-9,06,98.0,0.1\n' for k in range(20))
    assert main([str(table(HEAD + rows)), '--ground', '66']) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert '20 rows left out' in line
    assert 'decimal commas' in line


@pytest.mark.parametrize('encoding', ['utf-8-sig', 'utf-16', 'cp1252'])
def test_a_table_of_a_spreadsheet_is_read(tmp_path, encoding):
    """With semicolons, decimal commas and its own encoding."""
    path = tmp_path / 'readings.csv'
    text = 'vehicle;east_m;north_m;up_m;dose_rate_usvh\nM\u00f6we;1,5;2;30,25;0,1\n'
    path.write_text(text, encoding=encoding)
    (one,) = read_readings(path).observations
    assert one.position_enu_m == (1.5, 2.0, 30.25)
    assert one.dose_rate_usvh == 0.1


def test_counts_without_dose_rates_want_the_sensitivity(table, capsys):
    """One line says so, no traceback."""
    rows = ''.join(f'53.28,{-9.06 + k * 1e-4:.4f},90,{100 + k},1\n' for k in range(20))
    path = table('latitude_deg,longitude_deg,altitude_m,counts,live_time_s\n' + rows)
    assert main([str(path), '--ground', '66']) == 2
    assert '--sensitivity' in capsys.readouterr().err


def test_a_column_given_twice_is_refused(table):
    """Which of them counts, nobody knows."""
    text = 'east_m,north_m,up_m,dose_rate_usvh,dose_rate_usvh\n1,2,3,4,5\n'
    with pytest.raises(ReadingsFileError, match='column dose_rate_usvh more than once'):
        read_readings(table(text))


@pytest.mark.slow
def test_notes_are_part_of_the_json(table, capsys):
    """What was left out, and where."""
    text = HEAD + derailment() + '999,rav1,0.0,0.0,1.0,0.1\n'
    assert main([str(table(text)), '--json', '--ground', '66']) == 0
    (note,) = json.loads(capsys.readouterr().out)['notes']
    assert note == '1 rows left out: a place at 0, 0 (line 444)'


@pytest.mark.parametrize(
    ('lines', 'words'),
    [
        (['# of a detector', '', 'sep=,'], ''),
        (['50,"rav1,53.28,-9.06,98.0,0.1'], 'a quotation mark before line'),
        (['latitude;longitude'], "in its first line: 'latitude, longitude'"),
    ],
)
def test_what_stands_above_the_names_of_columns_is_passed_over_or_refused(table, lines, words):
    """Comments, empty lines and a line of Excel; not a quotation mark that takes all rows in."""
    rows = ''.join(ROW.format(number, number) for number in range(20))
    is_after = words.startswith('a quotation')
    above = ''.join(f'{line}\n' for line in lines)
    path = table(HEAD + above + rows if is_after else above + HEAD + rows)
    if words:
        with pytest.raises(ReadingsFileError, match=re.escape(words)):
            read_readings(path)
    else:
        bad = read_readings(table(above + HEAD + 'x\n' + rows)).dropped
        assert [*bad.values()] == [(len(lines) + 2,)]


def caveats_of(path, *options):
    """Return why the readings of a file prove nothing."""
    given = parser().parse_args([str(path), *options])
    return file_survey(read_readings(path, ground_altitude_m=given.ground), given).caveats


COUNTED = 'time_ns,vehicle,east_m,north_m,up_m,dose_rate_usvh,counts,live_time_s\n'


def counted(counts, unit=550.0, east=lambda k: k):
    """Return rows of counts and their dose rates."""
    return COUNTED + ''.join(
        f'{k},a,{east(k)},0,30,{count / unit},{count},1\n' for k, count in enumerate(counts)
    )


def test_readings_that_prove_nothing_say_why(table):
    """A detector read five times a count, a wrong unit, and rows that may be the right ones."""
    drawn = np.random.default_rng(1).poisson(55.0, 100).tolist()
    assert caveats_of(table(counted(drawn))) == ()
    (repeated,) = caveats_of(table(counted(np.repeat(drawn, 5).tolist())))
    assert 'readings are those before again' in repeated
    (unit,) = caveats_of(table(counted(drawn, 550_000.0)))
    assert 'is below that of nature' in unit
    (far,) = caveats_of(table(counted(drawn, east=lambda k: k + 5e4 * (k % 5 < 2))))
    assert '40 of 100 rows are left out, or the others are wrong' in far
    assert caveats_of(table(counted(drawn, east=lambda k: k + 5e4 * (k % 5 < 1)))) == ()


def test_a_count_that_is_read_again_counts_once(table):
    """A logger faster than its detector made ellipses smaller by the root of its factor."""
    drawn = np.random.default_rng(1).poisson(55.0, 100)
    kept = read_readings(table(counted(np.repeat(drawn, 5).tolist()))).observations
    assert [one.counts for one in kept] == drawn[np.diff(drawn, prepend=-1) != 0].tolist()


def test_a_detector_that_shows_no_more_is_saturated(table):
    """The end of its scale made two sources of one; a column that tells is believed."""
    mean = 50.0 + 5e6 / ((np.arange(100.0) - 50.0) ** 2 + 900.0)
    drawn = np.minimum(np.random.default_rng(1).poisson(mean), 3000)
    readings = read_readings(table(counted(drawn.tolist())))
    assert len(readings.observations) == (drawn < 3000).sum() < 80
    assert [*readings.dropped] == ['the largest that the detector shows: saturated']
    head, *rows = counted(drawn.tolist()).splitlines()
    told = '\n'.join([head + ',saturated', *(row + ',0' for row in rows)])
    assert 'saturated' not in ''.join(read_readings(table(told)).dropped)


def test_a_lowest_altitude_that_no_climb_leads_to_is_no_ground(table, capsys):
    """As of a fix without an altitude, 0."""
    rows = ''.join(f'{k},rav1,53.28,-9.{k:04d},430.0,0.1\n' for k in range(600, 700))
    path = str(table(HEAD + '1,rav1,53.28,-9.065,0.0,0.1\n' + rows))
    assert main([path]) == 2
    assert 'with a gap in between' in capsys.readouterr().err


def test_counts_that_are_no_number_leave_the_dose_rate(table):
    """They are not 0 counts."""
    rows = ''.join(f'{k},a,{k},0,30,0.1,{"nan" if k % 2 else 55},1\n' for k in range(20))
    readings = read_readings(table(COUNTED + rows))
    survey = survey_of(readings.observations)
    assert (survey.net_counts / survey.exposures) == pytest.approx(0.1)


def unlike(factor: float, *, has_doses: bool) -> str:
    """Return rows of two detectors over the same ground, the second with more counts."""
    rng = np.random.default_rng(6)
    lines = ['instrument,latitude_deg,longitude_deg,altitude_m,counts,live_time_s,dose_rate_usvh']
    for number in range(120):
        for name, sensitivity in (('tube', 200.0), ('crystal', 200.0 * factor)):
            place = 53.28 + 1e-4 * (number % 11), -9.06 + 1e-4 * (number // 11)
            counts = rng.poisson(0.1 * sensitivity)
            dose = f'{counts / 200.0:.4f}' if has_doses else ''
            lines.append(f'{name},{place[0]},{place[1]},90,{counts},1,{dose}')
    return '\n'.join(lines) + '\n'


def test_one_sensitivity_for_unlike_detectors_is_refused(table, capsys):
    """By their names; those that read alike pass, and dose rates that differ are never enough."""
    options = ['--ground', '66', '--sensitivity', '200']
    assert main([str(table(unlike(2.5, has_doses=False))), *options]) == 2
    error = capsys.readouterr().err
    assert "at the same places 'tube' reads 0.4" in error
    assert "times what 'crystal' reads" in error
    assert error.count('\n') == 1
    assert main([str(table(unlike(1.0, has_doses=False))), *options]) == 0
    assert main([str(table(unlike(2.5, has_doses=True))), *options[:2], '--json']) == 0
    document = json.loads(capsys.readouterr().out.partition('{')[2].join(['{', '']))
    assert not document['is_enough']
    assert any('the detectors differ' in doubt for doubt in document['doubts'])
