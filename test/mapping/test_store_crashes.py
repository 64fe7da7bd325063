# SPDX-License-Identifier: Apache-2.0
"""Whenever the collector dies and whatever the disk refuses: nothing acknowledged is lost."""

import errno
import hashlib
import json
import os
import resource
import signal
import sys

import pytest

from rocsafe_geo.storage import durable
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.store.store import ImageStore, Status

SHOTS = 2
# More than the operations that storing SHOTS photographs takes: the loop below must end by itself.
MOST_OPERATIONS = 200
KILLED = -signal.SIGKILL
FULL = 'No space left on device'


def in_child(work):
    """Run `work` in a forked child; return its exit status, or minus the signal that ended it."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            work()
            status = 0
        finally:
            os._exit(status)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def die_before(operation):
    """Kill this process before its n-th change of the disk from now, or amid a write."""
    count = 0
    changes = ('os.rename', 'os.remove', 'os.truncate', 'os.mkdir')
    fsync, write = os.fsync, os.write

    def tick():
        nonlocal count
        count += 1
        if count == operation:
            os.kill(os.getpid(), signal.SIGKILL)

    def on_event(event, arguments):
        writes = event == 'open' and arguments[2] & (os.O_WRONLY | os.O_RDWR)
        if event in changes or writes:
            tick()

    def ticking_fsync(descriptor):
        tick()
        fsync(descriptor)

    def torn_write(descriptor, data):
        half = len(data) // 2
        write(descriptor, data[:half])
        tick()
        return half + write(descriptor, data[half:])

    sys.addaudithook(on_event)
    os.fsync, os.write = ticking_fsync, torn_write


def check_whole(directory, shots):
    """Check that the store holds `shots`, each once and intact, and nothing else."""
    lines = [json.loads(line) for line in (directory / 'manifest.jsonl').read_text().splitlines()]
    assert sorted(line['shot_id'] for line in lines) == [record.shot_id for record, _ in shots]
    for line in lines:
        stored = (directory / line['image']).read_bytes()
        assert hashlib.sha256(stored).hexdigest() == line['stored_sha256']
    assert len(list(directory.glob('rav*'))) == 2 * len(shots)


def collect_until(directory, acknowledged, shots, operation):
    """Store `shots`, noting each receipt in `acknowledged`, and die at `operation`."""
    receipts, write = os.open(acknowledged, os.O_WRONLY | os.O_CREAT), os.write
    die_before(operation)
    store = ImageStore(directory)
    for record, image in shots:
        assert store.put(record, image).status is Status.STORED
        write(receipts, record.shot_id.encode() + b'\n')


@pytest.mark.slow
def test_killed_at_any_operation_the_next_collector_goes_on(tmp_path, shot):
    """Every point between two changes of the disk; acknowledged photographs are found again."""
    shots = [shot(number) for number in range(SHOTS)]
    for operation in range(1, MOST_OPERATIONS):
        directory, receipts = tmp_path / str(operation), tmp_path / f'{operation}.receipts'
        # Bound now: the child runs at once.
        status = in_child(lambda: collect_until(directory, receipts, shots, operation))  # noqa: B023
        known = receipts.read_text().split()
        store = ImageStore(directory)
        statuses = {record.shot_id: store.put(record, image).status for record, image in shots}
        store.close()
        assert all(statuses[shot_id] is Status.DUPLICATE for shot_id in known)
        check_whole(directory, shots)
        if status == 0:
            break
        assert status == KILLED
    assert status == 0
    assert len(known) == SHOTS
    # A photograph takes two files, their names, the directory and the manifest: eight changes.
    assert operation > SHOTS * 8


def test_a_photograph_that_lacks_only_its_line_is_adopted(tmp_path, shot):
    """Its vehicle may never come back to send it again."""
    store = ImageStore(tmp_path)
    store.put(*shot(0))
    store.close()
    (tmp_path / 'manifest.jsonl').write_bytes(b'')
    notices = []
    store = ImageStore(tmp_path, notices.append)
    assert len(store) == 1
    assert 'rav1-00000' in notices[0]
    store.close()
    check_whole(tmp_path, [shot(0)])


def test_a_torn_last_line_is_cut_off(tmp_path, shot):
    """A later line does not grow onto it."""
    store = ImageStore(tmp_path)
    store.put(*shot(0))
    store.close()
    with (tmp_path / 'manifest.jsonl').open('ab') as manifest:
        manifest.write(b'{"shot_id": "rav1-000')
    store = ImageStore(tmp_path)
    store.put(*shot(1))
    store.close()
    check_whole(tmp_path, [shot(0), shot(1)])


def test_a_damaged_line_is_told_and_its_photograph_adopted(tmp_path, shot):
    """The manifest can be made again from the files."""
    store = ImageStore(tmp_path)
    for number in range(2):
        store.put(*shot(number))
    store.close()
    lines = (tmp_path / 'manifest.jsonl').read_bytes().splitlines()
    (tmp_path / 'manifest.jsonl').write_bytes(b'#' * 10 + b'\n' + lines[1] + b'\n')
    notices = []
    store = ImageStore(tmp_path, notices.append)
    assert len(store) == 2
    assert notices[0] == 'manifest.jsonl line 1 is damaged'
    store.close()


@pytest.mark.parametrize('name', ['rav1-00000.jpg', 'rav1-00000.json'])
def test_a_photograph_whose_file_is_gone_is_stored_anew(tmp_path, shot, name):
    """The store never answers DUPLICATE for what it lost."""
    store = ImageStore(tmp_path)
    store.put(*shot(0))
    store.close()
    (tmp_path / name).unlink()
    notices = []
    store = ImageStore(tmp_path, notices.append)
    assert 'rav1-00000 is missing or damaged' in notices[0]
    assert store.put(*shot(0)).status is Status.STORED
    assert (tmp_path / name).exists()
    store.close()


def fill_disk_at(monkeypatch, failing):
    """Let the n-th write or sync from now find the disk full."""
    fsync, write_all, count = os.fsync, durable._write_all, 0

    def count_one():
        nonlocal count
        count += 1
        if count == failing:
            raise OSError(errno.ENOSPC, FULL)

    def full_fsync(descriptor):
        count_one()
        fsync(descriptor)

    def full_write(descriptor, data):
        os.write(descriptor, data[:10])
        count_one()
        write_all(descriptor, data[10:])

    monkeypatch.setattr(os, 'fsync', full_fsync)
    monkeypatch.setattr(durable, '_write_all', full_write)


@pytest.mark.parametrize('failing', range(1, 6))
def test_a_full_disk_acknowledges_nothing_and_spoils_nothing(tmp_path, shot, monkeypatch, failing):
    """At each of the five operations that may find the disk full."""
    store = ImageStore(tmp_path)
    store.put(*shot(0))
    with monkeypatch.context() as patch:
        fill_disk_at(patch, failing)
        with pytest.raises(StoreError, match=f'cannot store rav1-00001 at .*{FULL}'):
            store.put(*shot(1))
        assert store.put(*shot(2)).status is Status.STORED
    assert not list(tmp_path.glob('*.part'))
    statuses = [store.put(*shot(number)).status for number in range(3)]
    assert statuses == [Status.DUPLICATE, Status.STORED, Status.DUPLICATE]
    store.close()
    check_whole(tmp_path, [shot(number) for number in range(3)])


def test_a_file_that_the_kernel_will_not_let_grow_is_one_clear_error(tmp_path, shot):
    """The kernel's own refusal, not a pretended one."""

    def collect():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        store = ImageStore(tmp_path)
        resource.setrlimit(resource.RLIMIT_FSIZE, (200, resource.RLIM_INFINITY))
        try:
            store.put(*shot(0))
        except StoreError as error:
            (tmp_path / 'refusal').write_text(str(error)[:200])

    in_child(collect)
    assert 'cannot store rav1-00000' in (tmp_path / 'refusal').read_text()
    assert not list(tmp_path.glob('rav*'))


def test_lines_hold_no_line_ends(tmp_path):
    """A line with an end inside would read back as two."""
    file = durable.AppendOnlyFile(tmp_path / 'lines')
    with pytest.raises(ValueError, match='line end'):
        file.append(b'a\nb')
    file.close()
