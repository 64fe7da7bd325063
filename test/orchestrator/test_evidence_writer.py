# SPDX-License-Identifier: Apache-2.0
"""The evidence log beside a recorder: what waits is not lost while the disk is full."""

import time

from rocsafe_geo.evidence.evidence_log import Event, EvidenceLog, read_log
from rocsafe_orchestrator.recording.evidence_writer import EvidenceWriter


def event(number: int) -> Event:
    """Return an event with a number."""
    return Event(time_s=float(number), kind='decision', by='orchestrator', what={'number': number})


def test_what_cannot_be_written_waits(tmp_path, monkeypatch):
    """The fault is told once, and the order of the events is kept."""
    write, said = EvidenceLog.add, []

    def full(*_: object) -> None:
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(EvidenceLog, 'add', full)
    writer = EvidenceWriter(tmp_path / 'log', said.append)
    writer.add([event(1), event(2)])
    end_s = time.monotonic() + 20.0
    while not said and time.monotonic() < end_s:
        time.sleep(0.01)
    monkeypatch.setattr(EvidenceLog, 'add', write)
    writer.add([event(3)])
    writer.close()
    assert [entry['number'] for entry in read_log(tmp_path / 'log')] == [1, 2, 3]
    assert len(said) == 1
    assert 'No space left' in said[0]


def test_a_log_that_somebody_has_changed_is_told_and_stays(tmp_path):
    """The recording goes on; the changed log is not overwritten."""
    path = tmp_path / 'log'
    path.write_bytes(b'{"n":1}\n')
    said: list[str] = []
    writer = EvidenceWriter(path, said.append)
    writer.add([event(1)])
    writer.close()
    assert path.read_bytes() == b'{"n":1}\n'
    assert 'has been changed' in said[0]
