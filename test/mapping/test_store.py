# SPDX-License-Identifier: Apache-2.0
"""The store keeps each photograph exactly once and never claims what it does not have."""

import hashlib
import json

import pytest

from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.shot import plain_of_record, record_of_plain
from rocsafe_mapping.store.catalogue import read_shot, read_store
from rocsafe_mapping.store.store import ImageStore, Status


@pytest.fixture
def notices():
    """What the store found out of order."""
    return []


@pytest.fixture
def store(tmp_path, notices):
    """An empty store."""
    store = ImageStore(tmp_path / 'images', notices.append)
    yield store
    store.close()


def names(directory):
    """Return the names of the photographs' files."""
    return sorted(path.name for path in directory.glob('rav*'))


def test_a_photograph_is_stored_with_record_and_manifest_line(tmp_path, store, shot):
    """Hashes of what came and of what was written."""
    record, image = shot(12)
    answer = store.put(record, image)
    assert answer.status is Status.STORED
    assert answer.path == tmp_path / 'images' / 'rav1-00012.jpg'
    (line,) = (tmp_path / 'images' / 'manifest.jsonl').read_text().splitlines()
    entry = json.loads(line)
    assert entry['received_sha256'] == record.sha256 == answer.sha256
    assert entry['stored_sha256'] == hashlib.sha256(answer.path.read_bytes()).hexdigest()
    assert entry['stored_bytes'] == answer.path.stat().st_size
    assert names(tmp_path / 'images') == ['rav1-00012.jpg', 'rav1-00012.json']


def test_what_is_read_is_what_was_put(tmp_path, store, shot):
    """All of the record, unknown values included."""
    record, image = shot(3, height_agl_m=float('nan'))
    store.put(record, image)
    stored = read_shot(tmp_path / 'images', record.shot_id)
    assert plain_of_record(stored.record) == plain_of_record(record)
    assert str(stored.record.height_agl_m) == 'nan'
    assert stored.record.camera == record.camera


def test_a_photograph_sent_again_is_a_duplicate(tmp_path, store, shot):
    """One file, one line, the same path."""
    first = store.put(*shot())
    again = store.put(*shot())
    assert (again.status, again.path) == (Status.DUPLICATE, first.path)
    assert len((tmp_path / 'images' / 'manifest.jsonl').read_text().splitlines()) == 1


def test_a_damaged_image_is_rejected_by_its_hash(tmp_path, store, shot):
    """The answer names the hash of what came: the vehicle sees that it was not its image."""
    record, image = shot()
    damaged = image[:-3] + b'xyz'
    answer = store.put(record, damaged)
    assert answer.status is Status.REJECTED
    assert record.sha256 in answer.reason
    assert answer.sha256 == hashlib.sha256(damaged).hexdigest()
    assert names(tmp_path / 'images') == []
    assert store.put(record, image).status is Status.STORED


def test_another_image_of_the_same_name_is_rejected_and_kept_apart(tmp_path, store, shot):
    """What was acknowledged is never overwritten."""
    record, image = shot(0)
    other_image = shot(1)[1]
    first = store.put(record, image)
    before = first.path.read_bytes()
    answer = store.put(*shot(0, image=other_image))
    assert answer.status is Status.REJECTED
    assert 'rav1-00000 is stored already' in answer.reason
    assert first.path.read_bytes() == before
    assert (tmp_path / 'images' / 'rejected' / answer.sha256).read_bytes() == other_image


@pytest.mark.parametrize('data', [b'', b'no image', b'\xff\xd8\xff\xe0 torn'])
def test_what_cannot_be_decoded_is_kept_apart(tmp_path, store, shot, data):
    """Quarantined under its hash, with no line in the manifest."""
    answer = store.put(*shot(0, image=data))
    assert answer.status is Status.REJECTED
    assert 'cannot be decoded' in answer.reason
    assert (tmp_path / 'images' / 'rejected' / answer.sha256).read_bytes() == data
    assert len(store) == 0


def test_a_truncated_jpeg_is_rejected(store, shot):
    """Half a photograph is not stored as a whole one."""
    image = shot()[1]
    answer = store.put(*shot(0, image=image[: len(image) // 2]))
    assert (answer.status, 'cannot be decoded' in answer.reason) == (Status.REJECTED, True)


@pytest.mark.parametrize(
    'change',
    [
        {'shot_id': '../rav1-00000'},
        {'shot_id': 'rav1-00001'},
        {'shot_id': 'rav1-0'},
        {'vehicle': '../../etc', 'shot_id': '../../etc-00000'},
        {'vehicle': 'a/b', 'shot_id': 'a/b-00000'},
        {'vehicle': '.hidden', 'shot_id': '.hidden-00000'},
        {'vehicle': 'rav1\n', 'shot_id': 'rav1\n-00000'},
        {'vehicle': 'r' * 65, 'shot_id': 'r' * 65 + '-00000'},
        {'sequence': -1, 'shot_id': 'rav1--0001'},
        {'sha256': 'AB' * 32},
        {'latitude_deg': 90.5},
        {'longitude_deg': -181.0},
        {'time_ns': -1},
        {'position_covariance_m2': (1.0,)},
    ],
)
def test_a_record_that_makes_no_sense_is_refused(shot, change):
    """Names of files above all."""
    with pytest.raises(ValueError, match='must'):
        shot(0, **change)


@pytest.mark.parametrize('plain', [{}, {'shot_id': 'rav1-00000'}, {'camera': 3}])
def test_a_file_that_is_no_record_is_refused(plain):
    """As one error, whatever is wrong with it."""
    with pytest.raises(ValueError, match='not the record of a photograph'):
        record_of_plain(plain)


@pytest.mark.parametrize(
    'change',
    [
        {'orientation_xyzw': ['a', 'b', 'c', 'd']},
        {'camera': {'width_px': 'wide'}},
        {'stored_bytes': None},
        {'stored_bytes': 1e400},
        {'sequence': 10**400},
        {'altitude_m': 10**400},
        {'shot_id': 'rav1-00001', 'sequence': 1},
    ],
)
def test_a_damaged_record_leaves_the_others_readable(tmp_path, store, shot, notices, change):
    """Values of another type ended in a traceback, here or while the map was made."""
    for number in range(2):
        store.put(*shot(number))
    path = tmp_path / 'images' / 'rav1-00000.json'
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    (found,) = read_store(tmp_path / 'images', notices.append)
    assert found.record.shot_id == 'rav1-00001'
    (notice,) = notices
    assert notice.startswith(f'cannot read record {path}: ')


@pytest.mark.parametrize(
    'line', ['[]', 'null', '[' * 100_000, '{"shot_id": [1]}', '{"shot_id": 3}']
)
def test_damaged_lines_of_the_manifest_are_passed_over(tmp_path, store, shot, line):
    """As lines that a crash cut off are."""
    store.put(*shot(0))
    with (tmp_path / 'images' / 'manifest.jsonl').open('a') as manifest:
        manifest.write(line + '\n')
        keys = {'received_sha256': '', 'stored_sha256': '', 'stored_bytes': 1, 'shot_id': None}
        manifest.write(json.dumps(keys) + '\n')
    assert len(read_store(tmp_path / 'images', pytest.fail)) == 1


def test_the_store_is_the_same_after_opening_it_again(tmp_path, shot, notices):
    """Nothing is stored twice over a restart."""
    first = ImageStore(tmp_path / 'images', notices.append)
    for number in range(3):
        first.put(*shot(number))
    first.close()
    second = ImageStore(tmp_path / 'images', notices.append)
    assert [second.put(*shot(number)).status for number in range(3)] == [Status.DUPLICATE] * 3
    assert second.put(*shot(3)).status is Status.STORED
    assert notices == []
    second.close()


def test_a_second_writer_is_refused(tmp_path, store):
    """Two collectors on one directory would interleave their manifests."""
    with pytest.raises(StoreError, match='in use by another process'):
        ImageStore(tmp_path / 'images')


def test_a_directory_that_cannot_be_made_is_one_clear_error(tmp_path):
    """A file stands where the directory should be."""
    (tmp_path / 'images').write_text('')
    with pytest.raises(StoreError, match='cannot use image store'):
        ImageStore(tmp_path / 'images')


def test_the_store_can_be_read_while_it_is_written(tmp_path, store, shot):
    """In the order of storing; a line still being written is not read."""
    for number in (2, 0, 1):
        store.put(*shot(number))
    with (tmp_path / 'images' / 'manifest.jsonl').open('ab') as manifest:
        manifest.write(b'{"shot_id": "rav1-0000')
    shots = read_store(tmp_path / 'images', pytest.fail)
    assert [stored.record.sequence for stored in shots] == [2, 0, 1]


def test_a_store_that_does_not_exist_yet_is_empty(tmp_path):
    """The mosaic may start before the collector."""
    assert read_store(tmp_path / 'nowhere', pytest.fail) == ()


def test_a_lost_record_leaves_the_others_readable(tmp_path, store, shot, notices):
    """And is told."""
    for number in range(2):
        store.put(*shot(number))
    (tmp_path / 'images' / 'rav1-00000.json').unlink()
    shots = read_store(tmp_path / 'images', notices.append)
    assert [stored.record.sequence for stored in shots] == [1]
    assert 'rav1-00000.json' in notices[0]


def test_the_reserve_of_the_disk_is_left_alone(tmp_path, shot):
    """Refused with what is free and what is kept, before the disk is full; nothing changes."""
    store = ImageStore(tmp_path, reserve_bytes=2**62)
    with pytest.raises(StoreError, match=r'as good as full: \d+ MiB are free, \d+ MiB are kept'):
        store.put(*shot())
    assert len(store) == 0
    assert not list(tmp_path.glob('*.jpg'))
    store.close()
