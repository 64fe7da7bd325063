# SPDX-License-Identifier: Apache-2.0
"""Evidence of a running flight: each once, bounded, and kept over restarts."""

from pathlib import Path

import pytest

from rocsafe_dispersion.command_line.advise_command import main
from rocsafe_dispersion.identification.advice import advice
from rocsafe_dispersion.identification.evidence import Report
from rocsafe_dispersion.identification.evidence_log import (
    MOST_REPORTS,
    REPORTS_FILE,
    EvidenceLog,
    ReportSpool,
)
from rocsafe_dispersion.mission_gas.gas_log import GasFlightReading

CHLORINE = Report(
    observation='smell_chlorine', is_true=True, witness='driver, of the train',
    time='2026-05-01T14:05:00Z', place_deg=(53.28, -9.06),
)  # fmt: skip
NO_FISH = Report(observation='smell_fish', is_true=False)


def reading(number: int, ppm: float, sensor: str = 'electrochemical_chlorine') -> GasFlightReading:
    """Return a reading of second `number`."""
    return GasFlightReading(
        vehicle='rav1', time_ns=number * 10**9, sensor=sensor, unit='ppm',
        calibration_gas='chlorine', latitude_deg=53.28, longitude_deg=-9.06, altitude_m=70.0,
        raw=ppm, corrected=ppm, std=0.1, limit=0.1, is_saturated=False,
    )  # fmt: skip


def test_all_evidence_together_names_the_agent() -> None:
    """Detectors, people and placard; what is told again changes nothing."""
    log = EvidenceLog()
    assert len(log) == 0
    assert all(log.add_gas(reading(number, 8.0)) for number in range(5))
    assert log.newest_ns == 4 * 10**9
    assert log.add_said(CHLORINE)
    assert log.add_said(1017)
    before, evidence = len(log), log.evidence()
    assert not log.add_said(CHLORINE)
    assert not log.add_said(1017)
    assert not log.add_gas(reading(3, 9.0))
    assert len(log) == before
    assert log.evidence() == evidence
    found = advice(evidence, (), 5).found.probabilities
    assert found[0][0] == 'chlorine'
    assert found[0][1] > 0.99


def test_a_restart_has_the_reports(tmp_path: Path) -> None:
    """A row that a crash cut off, or that says what is not known, is left out."""
    spool = ReportSpool(str(tmp_path))
    for said in (CHLORINE, NO_FISH, 1017):
        spool.keep(said)
    with (tmp_path / REPORTS_FILE).open('a', encoding='utf-8') as stream:
        stream.write('smell_of_nothing,1,,,,,\nsmell_chl')
    log = EvidenceLog()
    ReportSpool(str(tmp_path)).restore(log)
    evidence = log.evidence()
    assert evidence.reports == (CHLORINE, NO_FISH)
    assert evidence.un_number == 1017


@pytest.mark.parametrize(
    ('said', 'words'),
    [
        (3, 'un_number = 3 must be between 4 and 3999'),
        (Report(observation='smell_fish', is_true=True, witness='x' * 201), 'witness must have'),
    ],
)
def test_what_cannot_be_kept_is_refused(said: Report | int, words: str) -> None:
    """In one line, and nothing of it stays."""
    log = EvidenceLog()
    with pytest.raises(ValueError, match=words):
        log.add_said(said)
    assert len(log) == 0
    assert log.evidence().un_number is None


def test_a_flood_of_reports_ends() -> None:
    """At a number of them, told in the refusal."""
    log = EvidenceLog()
    for number in range(MOST_REPORTS):
        log.add_said(Report(observation='smell_fish', is_true=True, witness=str(number)))
    with pytest.raises(ValueError, match=f'{MOST_REPORTS} reports are kept'):
        log.add_said(NO_FISH)


def test_the_command_uses_what_was_reported_during_the_flight(tmp_path: Path, capsys) -> None:
    """With the parameter file of the run's estimator."""
    spool = tmp_path / 'spool'
    spool.mkdir()
    kept = ReportSpool(str(spool))
    kept.keep(CHLORINE)
    kept.keep(1017)
    parameters = tmp_path / 'estimator.yaml'
    parameters.write_text(
        f"/estimator:\n  ros__parameters:\n    spool_directory: '{spool}'\n", encoding='utf-8'
    )
    assert main(['--readings', str(parameters), '--json']) == 0
    text = capsys.readouterr().out
    assert '"name": "chlorine"' in text.split('}')[0]
    assert 'driver, of the train' in text
