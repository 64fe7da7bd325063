# SPDX-License-Identifier: Apache-2.0
"""The evidence log and the seal: every changed byte is found, and where."""

import base64
import hashlib
import json
import time
from contextlib import closing
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rocsafe_console.evidence.desk import CONSOLE_LOG, Desk
from rocsafe_console.evidence.seal import (
    make_key,
    notes_of,
    public_key_of,
    read_key,
    seal_run,
    seals_of,
    verify_run,
)
from rocsafe_console.seal_command import main as seal_main
from rocsafe_console.verify_command import main as verify_main
from rocsafe_geo.evidence.evidence_log import (
    LOG_NAME,
    Event,
    EvidenceError,
    EvidenceLog,
    checked,
    line_of,
    read_log,
    segment,
    segments_of,
    whole_lines,
)
from rocsafe_orchestrator.report.sections.people_view import people_rows


def order_at(time_s: float, by: str = 'anna', **what) -> Event:
    """Return an order for a log."""
    return Event(time_s=time_s, kind='order', by=by, what={'verb': 'hold', **what})


def log_of(path: Path, count: int = 5) -> list[bytes]:
    """Add lines to a log and return all lines of it."""
    log = EvidenceLog(path)
    for number in range(count):
        log.add([order_at(float(number), number=number)])
    log.close()
    return path.read_bytes().split(b'\n')[:-1]


def run_of(folder: Path) -> Path:
    """Make a run with a picture, a recording, a report and a log."""
    run = folder / 'run1'
    (run / 'images').mkdir(parents=True)
    (run / 'images' / 'rav1-00000.jpg').write_bytes(b'\xff\xd8 picture')
    (run / 'mission.mcap').write_bytes(bytes(range(256)))
    (run / 'report.html').write_text('<p>report</p>')
    log_of(run / LOG_NAME)
    return run


def test_a_log_goes_on_where_it_ended(tmp_path):
    """The chain continues over a restart of the process."""
    log_of(tmp_path / 'log', 3)
    log_of(tmp_path / 'log', 2)
    entries = checked((tmp_path / 'log').read_bytes().split(b'\n')[:-1])
    assert [entry['n'] for entry in entries] == [1, 2, 3, 4, 5]


def test_several_writers_make_one_chain(tmp_path):
    """Two consoles of one folder; a line that one left torn is cut off."""
    path = tmp_path / 'log'
    first, second = EvidenceLog(path), EvidenceLog(path)
    for number in range(6):
        (first, second)[number % 2].add([order_at(float(number))])
    with path.open('ab') as file:
        file.write(b'{"torn')
    second.add([order_at(9.0, 'bert'), order_at(9.5, 'bert')])
    assert [entry['n'] for entry in read_log(path)] == list(range(1, 9))
    path.write_bytes(b'')
    first.add([order_at(10.0)])
    second.add([order_at(11.0)])
    entries, fault = whole_lines(segment(path, 2))
    assert ([entry['kind'] for entry in entries], fault) == (['damaged', 'order', 'order'], '')
    assert entries[0]['why'] == 'log: lines have been removed'
    first.close()
    second.close()


@pytest.mark.slow
@given(st.data())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
def test_any_changed_byte_of_a_log_is_found(tmp_path_factory, data):
    """Whichever byte becomes whichever other one."""
    lines = _lines(tmp_path_factory)
    number = data.draw(st.integers(0, len(lines) - 1))
    at = data.draw(st.integers(0, len(lines[number]) - 1))
    byte = data.draw(st.integers(0, 255).filter(lambda value: value != lines[number][at]))
    changed = bytearray(lines[number])
    changed[at] = byte
    with pytest.raises(EvidenceError, match='line'):
        checked([*lines[:number], bytes(changed), *lines[number + 1 :]])


_made: list[bytes] = []


def _lines(factory) -> list[bytes]:
    if not _made:
        _made.extend(log_of(factory.mktemp('log') / 'log'))
    return _made


@pytest.mark.parametrize(
    'change',
    [
        lambda lines: lines[1:],
        lambda lines: [*lines[:2], *lines[3:]],
        lambda lines: [lines[1], lines[0], *lines[2:]],
        lambda lines: [*lines[:2], lines[1], *lines[2:]],
    ],
    ids=['first gone', 'one gone', 'two swapped', 'one twice'],
)
def test_lines_that_are_gone_or_moved_are_found(tmp_path, change):
    """The chain is broken there."""
    lines = log_of(tmp_path / 'log')
    with pytest.raises(EvidenceError, match='does not follow'):
        checked(change(lines))
    (tmp_path / 'log').write_bytes(b''.join(line + b'\n' for line in change(lines)))
    with closing(EvidenceLog(tmp_path / 'log')) as log:
        log.add([order_at(9.0)])
    assert 'does not follow' in read_first(tmp_path / 'log-0002')['why']


def read_first(path: Path) -> dict:
    """Return the first entry of a segment."""
    return json.loads(path.read_bytes().split(b'\n')[0])


def test_a_damaged_log_goes_on_and_verify_names_the_damage(tmp_path, key, capsys):
    """Nothing of it is overwritten; what is changed later is found, too; it can be sealed."""
    run = run_of(tmp_path)
    log, changed = run / LOG_NAME, (run / LOG_NAME).read_bytes().replace(b'anna', b'bert', 1)
    log.write_bytes(changed)
    log_of(log, 2)
    assert log.read_bytes() == changed
    log_of(log, 1)
    second = run / 'evidence-0002.jsonl'
    assert [entry['kind'] for entry in whole_lines(second)[0]] == ['damaged'] + ['order'] * 3
    assert people_rows(run)[5][2].startswith('found the log damaged')
    seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    damage = [
        f'{LOG_NAME}, line 1: has been changed; the log goes on in {second.name}',
        f'{LOG_NAME}: was damaged when {second.name} began: {LOG_NAME}, line 1: has been changed',
    ]
    assert verify_run(run) == damage
    assert verify_main([str(run)]) == 1
    assert 'line 1: has been changed' in capsys.readouterr().out
    log.write_bytes(changed + b'x\n')
    assert verify_run(run) == [*damage, f'{LOG_NAME}: has been changed since']
    log.unlink()
    assert verify_run(run) == [damage[1], f'{LOG_NAME}: has been changed since']
    log.write_bytes(changed)
    second.write_bytes(second.read_bytes().replace(b'anna', b'bert', 1))
    assert f'{second.name}, line 2: has been changed' in verify_run(run)
    with pytest.raises(EvidenceError, match='evidence-0002'):
        seal_run(run, 2.0, 'anna', '0.2.0', read_key(key))


def test_damage_of_what_was_sealed_is_not_sealed_again(tmp_path, key):
    """The log goes on; no new seal makes the old lines new."""
    run = run_of(tmp_path)
    seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    log = run / LOG_NAME
    log.write_bytes(log.read_bytes().replace(b'anna', b'bert', 1))
    log_of(log, 1)
    with pytest.raises(EvidenceError, match='has 0 lines, 5 were sealed'):
        seal_run(run, 2.0, 'anna', '0.2.0', read_key(key))
    assert any('line 1: has been changed' in fault for fault in verify_run(run))


def test_a_log_that_is_taken_away_goes_on(tmp_path):
    """Removed, or another file in its place: writers that have it open notice."""
    path = tmp_path / LOG_NAME
    with closing(EvidenceLog(path)) as log:
        log.add([order_at(1.0)])
        path.unlink()
        log.add([order_at(2.0)])
        second = segment(path, 2)
        second.rename(tmp_path / 'kept')
        second.write_bytes((tmp_path / 'kept').read_bytes())
        log.add([order_at(3.0)])
    assert [one.name for one in segments_of(path)] == [second.name, 'evidence-0003.jsonl']
    assert read_first(second)['why'] == f'{LOG_NAME}: is gone'
    assert read_first(segment(path, 3))['why'] == f'{second.name}: another file has its name'


@pytest.fixture
def key(tmp_path):
    """Return the file of a signing key."""
    path = tmp_path / 'keys' / 'signing.key'
    make_key(path)
    return path


def test_a_sealed_run_is_as_it_was(tmp_path, key):
    """Also after more lines of the log; another key is told."""
    run = run_of(tmp_path)
    seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    assert verify_run(run, public_key_of(key)) == []
    log_of(run / LOG_NAME, 1)
    assert verify_run(run) == []
    assert 'is not signed with the key' in verify_run(run, 'AAAA')[0]


@pytest.mark.slow
@pytest.mark.parametrize('name', ['images/rav1-00000.jpg', 'mission.mcap', 'report.html'])
def test_any_changed_byte_of_a_file_is_found(tmp_path, key, name):
    """By the name of the file: changed, gone or added."""
    run = run_of(tmp_path)
    seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    data = bytearray((run / name).read_bytes())
    for at in range(len(data)):
        data[at] ^= 1
        (run / name).write_bytes(data)
        assert verify_run(run) == [f'{name}: has been changed']
        data[at] ^= 1
    (run / name).unlink()
    assert verify_run(run) == [f'{name}: is gone']
    (run / name).write_bytes(data)
    (run / 'more.txt').write_text('x')
    assert verify_run(run) == ['more.txt: is not in the seal']


def test_any_changed_value_of_a_seal_is_found(tmp_path, key):
    """Whoever changes a file and its hash cannot sign."""
    run = run_of(tmp_path)
    path = seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    seal = json.loads(path.read_text())
    seal['seal']['files']['mission.mcap']['sha256'] = '0' * 64
    path.write_text(json.dumps(seal, sort_keys=True, indent=1) + '\n')
    assert verify_run(run) == ['seal-0001.json: the signature is not right']


@pytest.mark.slow
def test_any_changed_byte_of_a_seal_is_found(tmp_path, key):
    """White space, letters of the signature that mean the same bytes, keys: all of them."""
    run = run_of(tmp_path)
    path = seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    data = path.read_bytes()
    for at in range(len(data)):
        path.write_bytes(data[:at] + bytes((data[at] ^ 1,)) + data[at + 1 :])
        assert verify_run(run), f'byte {at} of {data!r}'
    path.write_bytes(data + b' ')
    assert verify_run(run)
    twice = data.replace(b' "seal": {', b' "seal": {"by": "bert"},\n "seal": {', 1)
    path.write_bytes(twice)
    assert verify_run(run) == ['seal-0001.json: has been changed']


def forged_seal(run, change, key=None):
    """Write the next seal as somebody who does not use `seal_run`, and change what it says."""
    first = seals_of(run)[0]
    content = json.loads(first.read_text())['seal']
    content['before'] = hashlib.sha256(first.read_bytes()).hexdigest()
    change(content)
    signed = {'seal': content}
    if key is not None:
        signed['public_key'] = public_key_of(key)
        signed['signature'] = base64.b64encode(read_key(key).sign(line_of(content))).decode()
    path = run / 'seal-0002.json'
    path.write_bytes(json.dumps(signed, sort_keys=True, indent=1).encode() + b'\n')


def test_a_new_seal_hides_no_change_of_raw_evidence(tmp_path, key):
    """Neither one with the right key, nor one with another, nor one that nobody signed."""
    run = run_of(tmp_path)
    seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    (run / 'mission.mcap').write_bytes(b'other')
    files = {'sha256': hashlib.sha256(b'other').hexdigest(), 'bytes': 5}

    def change(content):
        content['files']['mission.mcap'] = files

    forged_seal(run, change, key)
    raw = 'seal-0002.json: mission.mcap: has been changed since seal-0001.json'
    assert verify_run(run) == [raw]
    other = tmp_path / 'other.key'
    make_key(other)
    for forger in (other, None):
        forged_seal(run, change, forger)
        signed = 'seal-0002.json: is not signed with the key of seal-0001.json'
        assert verify_run(run) == [signed, raw]
        with pytest.raises(EvidenceError, match='signed with'):
            seal_run(run, 3.0, 'anna', '0.2.0', read_key(key))


@pytest.mark.parametrize('damage', [
    lambda content: content.pop('files'),
    lambda content: content.update(files=[]),
    lambda content: content.update(log={'lines': 5}),
    lambda content: content.update(log=None),
    lambda content: content.update(log={'lines': 'x', 'last': ''}),
    lambda content: content.update(log={'lines': 0, 'last': None, 'name': 5}),
    lambda content: content.update(log={'lines': 0, 'last': None, 'name': '../x'}),
])  # fmt: skip
def test_a_seal_without_its_parts_is_told_in_one_line(tmp_path, damage):
    """Also where nobody has signed it."""
    run = run_of(tmp_path)
    seal_run(run, 1.0, 'anna', '0.2.0')
    forged_seal(run, damage)
    (line,) = verify_run(run)
    assert line.startswith('seal-0002.json: ')


def test_a_run_keeps_its_signer(tmp_path, key):
    """Whoever seals it again signs with the same key; what nobody signed can be signed later."""
    run = run_of(tmp_path)
    seal_run(run, 1.0, 'anna', '0.2.0')
    seal_run(run, 2.0, 'anna', '0.2.0', read_key(key))
    assert verify_run(run) == []
    with pytest.raises(EvidenceError, match='sign with this key'):
        seal_run(run, 3.0, 'bert', '0.2.0')


def test_a_log_that_lost_its_last_lines_is_found(tmp_path, key):
    """The chain alone would not tell."""
    run = run_of(tmp_path)
    seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    lines = (run / LOG_NAME).read_bytes().split(b'\n')[:-1]
    (run / LOG_NAME).write_bytes(b''.join(line + b'\n' for line in lines[:-1]))
    assert verify_run(run) == [f'{LOG_NAME}: has 4 lines, 5 were sealed']


def test_products_made_again_are_a_new_seal_and_raw_evidence_is_not(tmp_path, key):
    """The old seal stays; a raw file that differs is refused."""
    run = run_of(tmp_path)
    first = seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    before = first.read_bytes()
    (run / 'report.html').write_text('<p>again</p>')
    assert seal_run(run, 2.0, 'anna', '0.2.0', read_key(key)).name == 'seal-0002.json'
    assert first.read_bytes() == before
    assert verify_run(run) == []
    (run / 'mission.mcap').write_bytes(b'other')
    with pytest.raises(EvidenceError, match=r'mission\.mcap: has been changed'):
        seal_run(run, 3.0, 'anna', '0.2.0', read_key(key))
    first.write_bytes(before.replace(b'anna', b'bert'))
    assert verify_run(run)


def test_what_a_seal_does_not_cover_is_told(tmp_path, key, capsys):
    """Bytes after the last line, links, lines that were added, and another name of the run."""
    run = run_of(tmp_path)
    log_of(run / LOG_NAME, 1)
    seal_run(run, 1.0, 'anna', '0.2.0', read_key(key))
    log, sealed = run / LOG_NAME, (run / LOG_NAME).read_bytes()
    for tail in (b'x', b'\0\0', b'{"kind":"order"}'):
        log.write_bytes(sealed + tail)
        assert verify_run(run) == [f'{LOG_NAME}: its end is no line']
    log.write_bytes(sealed)
    (run / 'map').symlink_to(tmp_path)
    assert verify_run(run) == ['map: is not in the seal']
    (run / 'map').unlink()
    assert notes_of(run) == []
    log_of(log, 2)
    run = run.rename(tmp_path / 'another')
    assert verify_main([str(run)]) == 0
    told = capsys.readouterr().out
    assert 'the last 2 lines are in no seal' in told
    assert 'it was sealed as the run' in told


def test_the_commands_seal_and_verify(tmp_path, capsys):
    """Exit codes: 0 all well, 1 changed, 2 no run."""
    run, key = run_of(tmp_path), tmp_path / 'key'
    assert verify_main([str(run)]) == 1
    assert seal_main(['--key', str(key), '--make-key']) == 0
    assert seal_main(['--key', str(key), '--make-key']) == 1
    assert seal_main([str(run), '--key', str(key)]) == 0
    assert verify_main([str(run), '--public-key', public_key_of(key)]) == 0
    (run / 'mission.mcap').write_bytes(b'other')
    assert verify_main([str(run)]) == 1
    assert 'mission.mcap: has been changed' in capsys.readouterr().out
    assert verify_main([str(tmp_path / 'none')]) == 2
    key.chmod(0o644)
    assert seal_main([str(run), '--key', str(key)]) == 1


def test_events_go_to_the_log_of_their_run(tmp_path):
    """What belongs to no run goes to the log of the console, also after a restart."""
    for run in ('m1', 'm2'):
        (tmp_path / run).mkdir(exist_ok=True)
    for _ in range(2):
        desk = Desk(tmp_path)
        desk.write(order_at(0.0))
        desk.on_mission('m1')
        desk.write(order_at(1.0))
        desk.write(order_at(2.0), 'm2')
        desk.close()
    # The log of a mission is open before anybody writes.
    desk = Desk(tmp_path)
    desk.on_mission('m2')
    end_s = time.monotonic() + 10.0
    while not desk._logs:
        assert time.monotonic() < end_s
    assert list(desk._logs) == [tmp_path / 'm2' / LOG_NAME]
    desk.close()
    names = (f'm1/{LOG_NAME}', f'm2/{LOG_NAME}', CONSOLE_LOG)
    assert [len(read_log(tmp_path / name)) for name in names] == [2, 2, 2]
