# SPDX-License-Identifier: Apache-2.0
"""The command `locate-release`: anybody's readings, and what is refused."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from rocsafe_dispersion.command_line.locate_command import main
from rocsafe_dispersion.estimation.gas_csv import read_gas
from rocsafe_dispersion.estimation.locate import locate_releases
from rocsafe_dispersion.estimation.release_options import LocateOptions, SearchArea
from rocsafe_dispersion.plume.losses import Losses
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume

from .airs import EASTWARDS, LAYER, SPEED_MPS

HEAD = 'east_m,north_m,height_m,value_g_m3,wind_speed_mps,wind_from_deg'


def readings(folder: Path) -> Path:
    """Write the readings of a release of 2 g/s at (-20, 5) in a west wind."""
    release = Release(place_m=(-20.0, 5.0), height_m=0.5, rate_g_s=2.0)
    travel = similarity_travel(LAYER, 0.5)
    plume = SteadyPlume(release=release, travel=travel, wind=EASTWARDS)
    axis = np.arange(-45.0, 50.0, 15.0)
    lines = [HEAD]
    for east in axis:
        for north in axis + 0.3 * east % 7.0:
            (value,) = plume.concentrations_g_m3(np.array([[east, north, 2.0]]))
            lines.append(f'{east},{north},2,{value:.6g},{SPEED_MPS:.4g},270')
    path = folder / 'readings.csv'
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    return path


@pytest.mark.slow
def test_release_is_found_in_a_file(tmp_path: Path, capsys):
    """As JSON and as text."""
    path = readings(tmp_path)
    assert main([str(path), '--json', '--most', '1']) == 0
    (release,) = json.loads(capsys.readouterr().out)['releases']
    assert np.hypot(release['east_m'] + 20.0, release['north_m'] - 5.0) < 15.0
    assert release['rate_unit'] == 'g/s'
    assert 0.3 < release['rate'] / 2.0 < 3.0


@pytest.mark.slow
def test_counts_of_particles_that_settle_are_located(tmp_path: Path, capsys):
    """In particles a second; whoever is not told how they fall and decay finds less of them."""
    rate_per_s, litres = 3e9, 0.3
    losses = Losses(settling_mps=0.03, decay_per_s=0.02)
    plume = SteadyPlume(
        release=Release(place_m=(-20.0, 5.0), height_m=0.5, rate_g_s=rate_per_s),
        travel=similarity_travel(LAYER, 0.5, losses=losses), wind=EASTWARDS,
    )  # fmt: skip
    generator = np.random.default_rng(5)
    lines = [HEAD.replace('value_g_m3', 'count,litres')]
    for east in np.arange(-45.0, 50.0, 10.0):
        for north in np.arange(-45.0, 50.0, 10.0):
            (value,) = plume.concentrations_g_m3(np.array([[east, north, 2.0]]))
            count = generator.poisson(litres * (100.0 + value / 1000.0))
            lines.append(f'{east},{north},2,{count},{litres},{SPEED_MPS:.4g},270')
    path = tmp_path / 'counts.csv'
    path.write_text('\n'.join(lines) + '\n')
    told = ['--settling=0.03', '--decay=0.02']
    found = []
    for options in (told, []):
        assert main([str(path), '--json', '--most', '1', *options]) == 0
        document = json.loads(capsys.readouterr().out)
        assert 'backgrounds_per_m3' in document
        found += document['releases']
    first, untold = found
    assert np.hypot(first['east_m'] + 20.0, first['north_m'] - 5.0) < 15.0
    assert first['rate_unit'] == 'particles/s'
    assert first['rate_95'][0] < rate_per_s < first['rate_95'][1]
    assert untold['rate'] < 0.8 * first['rate']
    assert main([str(path), '--most', '1', *told]) == 0
    assert 'particles/s (95 %' in capsys.readouterr().out


@pytest.mark.slow
def test_start_and_another_release_are_told_in_words(tmp_path: Path, capsys):
    """Flown twice, the first time in clean air."""
    head, *rows = readings(tmp_path).read_text().splitlines()
    fields = [row.split(',') for row in rows]
    before = [[*row[:3], f'{1e-6 * (number % 3)}', *row[4:]] for number, row in enumerate(fields)]
    lines = [','.join([*row, str(10 * n)]) for n, row in enumerate(before + fields)]
    path = tmp_path / 'twice.csv'
    path.write_text('\n'.join([head + ',time_s', *lines]) + '\n')
    assert main([str(path), '--most', '1']) == 0
    told = capsys.readouterr().out
    assert '\nit started between ' in told
    assert 'ended between' not in told
    assert 'another of 0.5 g/s may be in' in told


def test_ppm_and_places_on_the_globe(tmp_path: Path):
    """Are converted; the wind, too."""
    path = tmp_path / 'a.csv'
    path.write_text(
        'latitude_deg,longitude_deg,height_m,value_ppm,std_ppm,limit,wind_speed_mps,wind_from_deg\n'
        '53.0,-9.0,2,10,1,,4,0\n53.0001,-9.0,2,1,1,below,4,90\n',
        encoding='utf-8',
    )
    survey = read_gas(path, lambda ppm: 0.003 * ppm).survey
    assert survey.values_g_m3 == pytest.approx([0.03, 0.003])
    assert survey.is_below.tolist() == [False, True]
    assert np.allclose(survey.wind_towards_mps, [(0.0, -4.0), (-4.0, 0.0)], atol=1e-9)
    assert np.ptp(survey.places_m[:, 0, 1]) == pytest.approx(11.1, abs=0.1)


def test_places_on_both_sides_of_180_degrees_are_neighbours(tmp_path: Path):
    """2.2 m apart at the equator."""
    path = tmp_path / 'a.csv'
    path.write_text(
        'latitude_deg,longitude_deg,height_m,value_g_m3,wind_speed_mps,wind_from_deg\n'
        '0,179.99999,2,1,4,0\n0,-179.99999,2,1,4,0\n0,-179.99999,2,1,4,0\n',
        encoding='utf-8',
    )
    assert np.ptp(read_gas(path).survey.places_m[:, 0, 0]) == pytest.approx(2.226, abs=0.01)


@pytest.mark.slow
def test_beams_are_means_along_their_way(tmp_path: Path):
    """A release is found by five beams across its plume that share one background."""
    release = Release(place_m=(-20.0, 5.0), height_m=0.5, rate_g_s=2.0)
    plume = SteadyPlume(release=release, travel=similarity_travel(LAYER, 0.5), wind=EASTWARDS)
    lines = [HEAD + ',to_east_m,to_north_m,to_height_m']
    for east, low, high in [
        (-5.0, -40.0, 5.0), (-5.0, 5.0, 40.0), (20.0, -40.0, 7.0), (20.0, 7.0, 40.0),
        (40.0, -10.0, 10.0), (-40.0, -30.0, 30.0),
    ]:  # fmt: skip
        way = np.column_stack(
            [np.full(2001, east), np.linspace(low, high, 2001), np.full(2001, 2.0)]
        )
        value = plume.concentrations_g_m3(way).mean() + 1e-3
        lines.append(f'{east},{low},2,{value:.6g},{SPEED_MPS:.4g},270,{east},{high},2')
    path = tmp_path / 'beams.csv'
    path.write_text('\n'.join(lines) + '\n', encoding='utf-8')
    survey = read_gas(path).survey
    means = plume.concentrations_g_m3(survey.places_m.reshape(-1, 3)).reshape(6, -1)
    assert means @ survey.weights + 1e-3 == pytest.approx(survey.values_g_m3, rel=0.02)
    area = SearchArea(west_m=-38.0, south_m=-40.0, east_m=42.0, north_m=40.0, cell_m=8.0)
    quick = LocateOptions(most_releases=1, least_gain=0.0)
    (found,) = locate_releases(survey, area, LAYER, options=quick).releases
    assert found.holds(-20.0, 5.0)


@pytest.mark.parametrize('encoding', ['utf-8-sig', 'utf-16'])
@pytest.mark.parametrize('unit', ['g_m3', 'mg_m3'])
def test_encodings_with_marks_and_milligrams_are_read(tmp_path: Path, encoding: str, unit: str):
    """One reading of 5 mg/m^3; names may have blanks about them."""
    value = {'g_m3': '0.005', 'mg_m3': '5'}[unit]
    head = HEAD.replace('g_m3', unit).replace(',', ' , ')
    path = tmp_path / 'a.csv'
    path.write_text(f'{head},std_{unit}\n1,2,3,{value},5,270,{value}\n', encoding=encoding)
    survey = read_gas(path).survey
    assert survey.values_g_m3 == pytest.approx([0.005])
    assert survey.std_g_m3 == pytest.approx([0.005])


def test_pipes_and_other_encodings_are_refused(tmp_path: Path):
    """A pipe would wait for a writer that never comes."""
    pipe, text = tmp_path / 'pipe', tmp_path / 'a.csv'
    os.mkfifo(pipe)
    with pytest.raises(ValueError, match='must be a file'):
        read_gas(pipe)
    text.write_bytes(b'caf\xe9\n1\n')
    with pytest.raises(ValueError, match='neither UTF-8 nor UTF-16'):
        read_gas(text)


@pytest.mark.parametrize(
    ('text', 'named'),
    [
        ('', '0 rows'),
        (HEAD + '\n', '0 rows'),
        (
            HEAD.replace('value_g_m3', 'value') + '\n1,2,3,4,5,6\n',
            'has 0 of the columns value_g_m3',
        ),
        (HEAD + ',value_ppm\n1,2,3,4,5,6,7\n', 'has 2 of the columns value_g_m3'),
        (HEAD.replace('value_g_m3', 'value_ppm') + '\n1,2,3,4,5,6\n', 'name the agent'),
        (HEAD.replace('wind_from_deg', 'wind_direction') + '\n1,2,3,4,5,6\n', 'does not say'),
        (HEAD.replace('height_m', 'h') + '\n1,2,3,4,5,6\n', 'height_m is missing'),
        (HEAD.replace('north_m', 'n') + '\n1,2,3,4,5,6\n', 'needs either latitude_deg'),
        (HEAD + '\n1,2,3,x,5,6\n', "line 2: value_g_m3 is 'x'"),
        (HEAD + '\n1,2,3,inf,5,6\n', 'must be finite'),
        (HEAD + '\n1,2,3,4,5,999\n', 'from_deg is 999'),
        (HEAD + '\n1,2,3,4,0,270\n9,9,3,4,0,270\n', 'the wind is below 0.3 m/s in most readings'),
        (HEAD + '\n1,2,3,4,5,270\n1,2,3,4,5,270\n1e9,2,3,4,5,270\n', 'line 4: is 1e+09 m'),
        ('\x00\xff', 'neither UTF-8 nor'),
        (HEAD.replace(',', ';') + '\n1;2;3;4;5;6\n', 'semicolons'),
        (HEAD + ',value_g_m3\n1,2,3,4,5,6,7\n', "'value_g_m3' is there 2 times"),
        (HEAD + ',latitude_deg,longitude_deg\n1,2,3,4,5,6,53,-9\n', 'needs either'),
        (HEAD + '\n1,2,3,0,5,270\n', 'std_g_m3 must tell the noise'),
        (HEAD + '\n1,2,3,1e300,5,270\n', 'line 2: value_g_m3'),
        (HEAD + ',std_g_m3\n1,2,3,4,5,270,0\n', 'line 2: std_g_m3 is 0'),
        (HEAD + ',std_g_m3\n1,2,3,4,5,270,1e-300\n', 'line 2: std_g_m3'),
        (HEAD + ',to_east_m,to_north_m\n1,2,3,4,5,270,9,9\n', 'to_height_m is missing'),
        (
            HEAD + ',to_east_m,to_north_m,to_height_m\n1,2,3,4,5,270,900,9,2\n',
            'line 2: length of the beam',
        ),
        (HEAD + '\n1,2,3,4,5\n', 'line 2: has 5 values: must be 6'),
        (HEAD + '\n1,2,3,0,004,5,270\n', 'line 2: has 7 values: must be 6'),
        (HEAD + '\n1,2,"3,5",4,5,270\n', 'with a decimal point'),
        (HEAD + '\n1,2,3,4,5,270\n\n' + HEAD + '\n', "line 4: height_m is 'height_m'"),
        (HEAD + '\n' + '1' * 20_000 + '\n', 'line 2: is longer than 10000 characters'),
        (HEAD + '\n1,2,3,4,1e300,270\n', 'line 2: speed_mps is 1e+300 m/s: must be 0 to 100'),
        (HEAD.replace('value_g_m3', 'count') + '\n1,2,3,4,5,270\n', 'a column litres must tell'),
        (
            HEAD.replace('value_g_m3', 'count,litres') + '\n1,2,3,-4,1,5,270\n',
            'line 2: count is -4',
        ),
        (
            HEAD.replace('value_g_m3', 'count,litres') + '\n1,2,3,4,0,5,270\n',
            'line 2: litres is 0',
        ),
        (HEAD + ',count\n1,2,3,4,5,270,7\n', 'has 2 of the columns value_g_m3'),
        (HEAD + '\n' + '1,2,3,4,5,270\n' * 20_001, 'has more than 20000 rows'),
    ],
)
def test_bad_files_are_refused_in_one_line(tmp_path: Path, capsys, text: str, named: str):
    """With exit code 2 and no traceback."""
    path = tmp_path / 'bad.csv'
    path.write_text(text, encoding='latin-1')
    assert main([str(path)]) == 2
    error = capsys.readouterr().err
    assert error.startswith('error: ')
    assert error.count('\n') == 1
    assert named in error or named == 'column'


def test_missing_file_and_unknown_agent_are_refused(tmp_path: Path, capsys):
    """By their names."""
    assert main([str(tmp_path / 'none.csv')]) == 2
    assert 'none.csv' in capsys.readouterr().err
    assert main([str(tmp_path / 'none.csv'), '--agent', 'water']) == 2
    assert 'water' in capsys.readouterr().err
    path = tmp_path / 'counts.csv'
    path.write_text(HEAD.replace('value_g_m3', 'value_per_l') + '\n1,2,3,4,5,270\n')
    assert main([str(path), '--agent', 'ammonia']) == 2
    assert 'counts particles: no agent may be named' in capsys.readouterr().err


def test_a_table_is_told_to_be_enough_or_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """Two readings say once that a release may be anywhere."""
    path = tmp_path / 'a.csv'
    path.write_text(HEAD + ',std_g_m3\n1,2,3,0,5,270,1e-5\n9,2,3,0,5,270,1e-5\n')
    assert main([str(path), '--most', '1']) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first.startswith('no release')
    assert second.startswith('not enough: a release of 0.5 g/s may be in ')


def clean(values: np.ndarray) -> str:
    """Return a file of such values along a line, in a west wind."""
    rows = (f'{k},{3 * k % 50},2,{value:.6g},4,270' for k, value in enumerate(values))
    return '\n'.join([HEAD, *rows]) + '\n'


def test_ends_of_the_scale_are_bounds_unless_a_column_says(tmp_path: Path):
    """A detector that shows nothing below 0 made releases of clean air."""
    path = tmp_path / 'a.csv'
    values = np.clip(np.random.default_rng(2).normal(0.0, 1e-3, 90), 0.0, 1e-3)
    path.write_text(clean(values), encoding='utf-8')
    gas = read_gas(path)
    assert (gas.survey.is_below == (values == 0.0)).all()
    assert (gas.survey.is_above == (values == 1e-3)).all()
    assert [note.partition(' readings')[2] for note in gas.notes] == [
        ' are the least that the detector shows: taken as bounds',
        ' are the most that the detector shows: taken as bounds',
    ]
    head, *rows = clean(values).splitlines()
    path.write_text('\n'.join([head + ',limit', *(row + ',' for row in rows)]), encoding='utf-8')
    assert not read_gas(path).survey.is_below.any()


@pytest.mark.slow
def test_a_value_that_is_read_again_counts_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    """The JSON says so, too; the noise is that of what is left."""
    path = tmp_path / 'a.csv'
    values = np.random.default_rng(2).normal(0.0, 1e-3, 60)
    path.write_text(clean(np.repeat(values, 5)), encoding='utf-8')
    found = read_gas(path).survey
    assert found.values_g_m3 == pytest.approx(values, rel=1e-4)
    assert found.std_g_m3[0] == pytest.approx(1e-3, rel=0.3)
    assert main([str(path), '--json', '--most', '0']) == 0
    (note,) = json.loads(capsys.readouterr().out)['notes']
    assert note == '240 readings left out: as before, read too often or stuck'


def test_rows_without_a_value_or_wind_and_calm_ones_are_left_out(tmp_path: Path, capsys):
    """With their number; the whole file was refused for one of them."""
    path = tmp_path / 'a.csv'
    head, *rows = clean(np.random.default_rng(2).normal(0.0, 1e-3, 60)).splitlines()
    rows[3], rows[5] = rows[3].replace(',4,270', ',,'), rows[5].replace(',4,', ',nan,')
    rows[7] = '7,21,2,,4,270'
    rows[9] = rows[9].replace(',4,270', ',0,270')
    path.write_text('\n'.join([head, *rows]) + '\n', encoding='utf-8')
    gas = read_gas(path)
    assert len(gas.survey.values_g_m3) == 56
    assert list(gas.notes) == [
        '1 readings left out: no value (lines 9)',
        '2 readings left out: no wind (lines 5, 7)',
        '1 readings left out: the wind is below 0.3 m/s',
    ]
    path.write_text('\n'.join([head, '1,2,3,4,,', '5,6,3,4,-,-']) + '\n', encoding='utf-8')
    assert main([str(path)]) == 2
    assert 'no row has a wind' in capsys.readouterr().err


@pytest.mark.slow
def test_a_slow_sensor_is_undone(tmp_path: Path, capsys):
    """A response of 30 s made releases of one far from it."""
    rng, (head, *rows) = np.random.default_rng(3), readings(tmp_path).read_text().splitlines()
    shown, lines = 0.0, []
    for number, row in enumerate([*rows, *rows[::-1]]):
        east, north, height, value, *wind = row.split(',')
        shown += (float(value) - shown) * (1.0 - np.exp(-8.0 / 30.0))
        reading = shown + rng.normal(0.0, 1e-5)
        lines.append(','.join([east, north, height, f'{reading:.7g}', *wind, str(8 * number)]))
    path = tmp_path / 'slow.csv'
    path.write_text('\n'.join([head + ',time_s', *lines]) + '\n', encoding='utf-8')
    assert main([str(path), '--json', '--most', '1']) == 0
    document = json.loads(capsys.readouterr().out)
    assert any('follows the gas within about' in note for note in document['notes'])
    (release,) = document['releases']
    assert np.hypot(release['east_m'] + 20.0, release['north_m'] - 5.0) < 12.0


@pytest.mark.slow
@pytest.mark.parametrize('value', [3.0, -1.0])
def test_readings_that_are_all_alike_tell_of_no_release(tmp_path: Path, capsys, value: float):
    """A stuck detector: the noise shrank to nothing, and a release of 484 g/s explained them."""
    path = tmp_path / 'a.csv'
    path.write_text(clean(np.full(90, value)), encoding='utf-8')
    assert main([str(path), '--json', '--most', '1']) == 0
    assert json.loads(capsys.readouterr().out)['releases'] == []


@pytest.mark.slow
def test_a_narrow_area_has_cells(tmp_path: Path, capsys):
    """One reading far along a road: the cells were wider than the area, which had none."""
    path = tmp_path / 'a.csv'
    values = np.random.default_rng(2).normal(0.0, 1e-3, 60)
    path.write_text(clean(values) + '15000,10,2,0.001,4,270\n', encoding='utf-8')
    assert main([str(path), '--most', '1']) == 0
    assert 'not enough' in capsys.readouterr().out
