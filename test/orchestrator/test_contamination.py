# SPDX-License-Identifier: Apache-2.0
"""Vehicles that may be contaminated, and the expected doses of people."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.cli import main
from rocsafe_orchestrator.contamination import FILE_NAME, contaminated, mark, require_clean
from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.watches.crew_dose import CrewDose, CrewMember, dose_rate_usvh

PLACE = GeoPosition(53.28, -9.06, 98.0)


def test_marked_vehicle_is_refused_until_it_is_cleared(tmp_path: Path) -> None:
    """The line says why, and what to do."""
    mark(tmp_path, {'rav1': 'it read 351 uSv/h in loss-1'})
    mark(tmp_path, {'rav1': 'it read 400 uSv/h in loss-2', 'rav2': 'it read 120 uSv/h in loss-2'})
    with pytest.raises(SetupError, match='rav1: may be contaminated: it read 351 uSv/h in loss-1'):
        require_clean(tmp_path, ('rav1', 'rav3'))
    require_clean(tmp_path, ('rav3',))
    assert main(['clear', 'rav1', '--out', str(tmp_path)]) == 0
    require_clean(tmp_path, ('rav1',))
    assert set(contaminated(tmp_path)) == {'rav2'}


@pytest.mark.parametrize('why', ['full', 'damaged'])
def test_mark_that_cannot_be_written_is_told_and_ends_nothing(tmp_path: Path, why: str) -> None:
    """The flight goes on, and a file that somebody damaged is left as it is."""
    folder = tmp_path / 'missing' if why == 'full' else tmp_path
    if why == 'damaged':
        (folder / FILE_NAME).write_text('{')
    told = mark(folder, {'rav1': 'it read 120 uSv/h'})
    assert told.startswith('rav1 could not be marked as contaminated: ')
    assert why == 'full' or (folder / FILE_NAME).read_text() == '{'


def test_clearing_a_vehicle_that_is_not_marked_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line, with those that are."""
    mark(tmp_path, {'rav2': 'it read 120 uSv/h'})
    assert main(['clear', 'rav1', '--out', str(tmp_path)]) != 0
    assert capsys.readouterr().err.endswith('marked: rav2\n')


@pytest.mark.parametrize('text', ['{', '[]', '{"rav1": 3}'])
def test_file_that_cannot_be_read_forbids_the_flight(tmp_path: Path, text: str) -> None:
    """Then nobody knows who is clean."""
    (tmp_path / FILE_NAME).write_text(text)
    with pytest.raises(SetupError, match=FILE_NAME):
        require_clean(tmp_path, ('rav1',))


@pytest.mark.parametrize(('limit', 'names'), [(100.0, {'rav1'}), (0.0, set()), (400.0, set())])
def test_vehicle_that_read_the_limit_may_be_contaminated(limit: float, names: set[str]) -> None:
    """It stays so, however little it reads later."""
    monitor = Monitor(('rav1',), contamination_usvh=limit)
    for rate in (3.0, 351.0, 0.1):
        monitor.on_dose_rate('rav1', rate, PLACE)
    assert set(monitor.contaminated) == names


def test_expected_dose_of_a_person_warns_and_sends_away() -> None:
    """At 36 mSv/h a budget of 20 mSv is used up after 2000 s."""
    dose = CrewDose(CrewMember(name='pilot', budget_usv=2e4))
    said = {time: dose.advance(float(time), 36_000.0) for time in range(0, 2401, 100)}
    told = {time: text for time, text in said.items() if text}
    assert list(told) == [1600, 2000]
    assert told[1600].startswith('pilot is to be relieved soon')
    assert told[2000].startswith('pilot must leave: expected dose 2e+04 uSv')


@given(st.lists(st.tuples(st.floats(0.0, 1e4), st.floats(0.0, 1e6)), max_size=30))
def test_dose_never_falls(steps: list[tuple[float, float]]) -> None:
    """Whatever the times and rates; each warning comes once."""
    dose, last, said = CrewDose(CrewMember(name='pilot', budget_usv=100.0)), 0.0, []
    for time_s, rate in steps:
        said.append(dose.advance(time_s, rate))
        assert dose.dose_usv >= last
        last = dose.dose_usv
    assert sum(bool(text) for text in said) <= 2


def test_dose_rate_beside_a_source_is_finite() -> None:
    """Nearer than a metre an estimate says nothing."""
    assert dose_rate_usvh([(0.0, 1e3), (10.0, 1e4)]) == pytest.approx(1e3 + 1e2)
