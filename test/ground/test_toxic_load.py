# SPDX-License-Identifier: Apache-2.0
"""The gas along a drive: highest concentration and toxic load, told beside the dose."""

import json
from pathlib import Path

import numpy as np
import pytest
from test.ground.villages import HALF_M, text, write_bands, write_village

from rocsafe_ground.command_line.ground_command import main
from rocsafe_ground.dose.toxic_load import PLUME, ZONES

MEAN_PPM, UPPER_PPM, LEVEL_PPM, EXPONENT = 100.0, 200.0, 160.0, 2.0
CELL_M = 2.0


def write_gas(folder: Path, *, exponent: float | None = EXPONENT, half_m: float = HALF_M) -> Path:
    """Write an even gas over the middle of the village."""
    count = round(2.0 * HALF_M / CELL_M)
    middles = (np.arange(count) + 0.5) * CELL_M - HALF_M
    east, north = np.meshgrid(middles, middles)
    inside = np.maximum(np.abs(east), np.abs(north)) <= half_m
    bands = [np.where(inside, ppm, np.nan) for ppm in (MEAN_PPM, UPPER_PPM)]
    write_bands(folder / PLUME, np.stack([*bands, np.zeros_like(east)]), CELL_M)
    properties = {
        'level': 'AEGL-2', 'averaging_minutes': 60.0, 'ppm': LEVEL_PPM, 'agent': 'ammonia',
        'kind': 'expected', 'load_exponent': exponent,
    }  # fmt: skip
    (folder / ZONES).write_text(json.dumps({'features': [{'properties': properties}]}))
    return folder


def driven(folder: Path, capsys, *options: str) -> dict:
    """Return the drive as the command tells it."""
    arguments = [str(folder), f'--from={text(-20.0, 7.0)}', f'--to={text(20.0, 9.0)}']
    options = (*options, '--dose-budget=1e6', '--turn-back=1e5', '--cell=0.5', '--json')
    assert main([*arguments, *options]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.fixture
def village(tmp_path: Path) -> Path:
    """Return the folder of a village."""
    return write_village(tmp_path)


@pytest.mark.slow
def test_load_of_an_even_gas_is_that_of_the_time_spent_in_it(village: Path, capsys) -> None:
    """(C / level)^n t / averaging time; without a gas the drive says nothing of one."""
    assert 'gas' not in driven(village, capsys)
    plan = driven(write_gas(village), capsys)
    gas = plan['gas']
    hours = plan['time_s'] / 3600.0
    assert gas['highest_ppm'] == pytest.approx(MEAN_PPM)
    assert gas['highest_upper_95_ppm'] == pytest.approx(UPPER_PPM)
    expected = (MEAN_PPM / LEVEL_PPM) ** EXPONENT * hours
    assert gas['toxic_load_share'] == pytest.approx(expected, rel=1e-4)
    assert gas['toxic_load_share_upper_95'] == pytest.approx(4.0 * expected, rel=1e-4)
    assert gas['toxic_load_of'] == 'AEGL-2, 60 min'
    assert gas['outside_the_map_s'] == 0.0


@pytest.mark.slow
def test_no_way_enters_the_concentration_to_turn_back_at(village: Path, capsys) -> None:
    """By its upper 95 %; without the level the way leads through it."""
    write_gas(village, half_m=8.0)
    through = driven(village, capsys)
    assert through['gas']['highest_upper_95_ppm'] == pytest.approx(UPPER_PPM)
    level = 0.75 * UPPER_PPM
    around = driven(village, capsys, f'--turn-back-ppm={level}')
    assert around['gas']['highest_upper_95_ppm'] < level
    inside = [str(village), f'--from={text(-20.0, 7.0)}', f'--to={text(0.0, 2.0)}']
    assert main([*inside, '--dose-budget=1e6', f'--turn-back-ppm={level}']) == 1
    assert 'a concentration of gas at which the vehicle turns back' in capsys.readouterr().err
    (village / PLUME).unlink()
    assert main([*inside, '--dose-budget=1e6', '--turn-back-ppm=150']) == 2
    assert capsys.readouterr().err.startswith('error: --turn-back-ppm: ')


@pytest.mark.slow
def test_what_is_not_known_is_said(village: Path, capsys) -> None:
    """No load without a published n; time outside the map of the gas is told."""
    plan = driven(write_gas(village, exponent=None, half_m=8.0), capsys)
    assert plan['gas']['toxic_load_share'] is None
    assert 0.0 < plan['gas']['outside_the_map_s'] < plan['time_s']


@pytest.mark.slow
@pytest.mark.parametrize('content', ['', '[]', '{"features": [{"properties": {}}]}'])
def test_files_of_gas_that_cannot_be_read_are_refused(village: Path, content: str, capsys) -> None:
    """In one line, with exit code 2: a drive without its gas would look harmless."""
    write_gas(village)
    (village / ZONES).write_text(content)
    assert main([str(village), f'--from={text(-20.0, 7.0)}', f'--to={text(20.0, 9.0)}',
                 '--dose-budget=1e6']) == 2  # fmt: skip
    error = capsys.readouterr().err
    assert error.startswith('error: ')
    assert 'cannot be read as threat zones' in error
    assert error.count('\n') == 1
