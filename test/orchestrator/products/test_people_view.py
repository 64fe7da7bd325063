# SPDX-License-Identifier: Apache-2.0
"""What people decided, as the report tells it."""

from pathlib import Path

from rocsafe_console.evidence.desk import Desk
from rocsafe_geo.evidence.evidence_log import Event
from rocsafe_orchestrator.report.sections.people_view import people_rows

NOON_S = 1_780_315_200.0


def written(folder: Path, *events: tuple[str, str, dict]) -> Path:
    """Return a run whose evidence log the console has written."""
    run = folder / 'run'
    run.mkdir()
    desk = Desk(folder)
    desk.on_mission('run')
    for number, (kind, by, what) in enumerate(events):
        desk.write(Event(time_s=NOON_S + number, kind=kind, by=by, what=what))
    desk.close()
    return run


def test_an_order_is_told_with_who_gave_it_and_what_became_of_it(tmp_path):
    """Also one for several vehicles of which one refuses."""
    results = [
        {'vehicle': 'rav1', 'outcome': 'done', 'text': ''},
        {'vehicle': 'rav2', 'outcome': 'refused', 'text': 'the pilot has it'},
    ]
    run = written(
        tmp_path,
        ('login', 'anna', {'address': '127.0.0.1', 'outcome': 'done'}),
        ('order', 'anna', {'request_id': 'a', 'verb': 'hold', 'vehicles': ['rav1', 'rav2']}),
        ('photograph', 'rav1', {'shot_id': 'rav1-00000', 'sha256': 'x'}),
        ('outcome', 'anna', {'request_id': 'a', 'results': results}),
        ('mark', 'ben', {'text': 'a drum', 'mgrs': '29UNV1234567890'}),
    )
    assert people_rows(run) == [
        (
            '12:00:01',
            'anna',
            'hold: rav1, rav2',
            'rav1 done; rav2 refused the pilot has it',
        ),
        ('12:00:04', 'ben', 'marked as evidence at 29UNV1234567890: a drum', ''),
    ]


def test_what_somebody_was_refused_is_told_with_the_reason(tmp_path):
    """An inquiry asks who tried what, too."""
    asked = {'verb': 'land', 'vehicles': ['rav1', 'rav2']}
    why = 'the role viewer may not land'
    run = written(
        tmp_path,
        (
            'refused',
            'ben',
            {'outcome': 'refused', 'path': '/api/orders', 'asked': asked, 'why': why},
        ),
        ('refused', 'ben', {'path': '/api/missions/yard/end', 'asked': None, 'why': 'no'}),
    )
    assert people_rows(run) == [
        ('12:00:00', 'ben', 'was refused: land: rav1, rav2', why),
        ('12:00:01', 'ben', 'was refused: /api/missions/yard/end', 'no'),
    ]


def test_a_damaged_line_is_told(tmp_path):
    """The other lines are read."""
    run = written(tmp_path, ('acknowledge', 'anna', {'alarm': 'rav1 is lost', 'number': 1}))
    log = run / 'evidence.jsonl'
    log.write_bytes(b'\xff{"kind"\n' + log.read_bytes())
    rows = people_rows(run)
    assert [row[2] for row in rows] == [
        'line 1 of evidence.jsonl cannot be read',
        'alarm seen: rav1 is lost',
    ]


def test_a_run_without_a_log_has_none(tmp_path):
    """As of a mission without a console."""
    assert people_rows(tmp_path) == []
