# SPDX-License-Identifier: Apache-2.0
"""Photographs are kept until their receipt, across kills, and sent again in time."""

from pathlib import Path

import pytest

from rocsafe_geo.evidence.shot import Shot, shot_of, shot_record
from rocsafe_geo.evidence.shot_store import RESEND_BURST, RESEND_S, ShotStore, SpoolError
from rocsafe_geo.position import GeoPosition


def shot(sequence: int = 0, jpeg: bytes = b'\xff\xd8picture') -> Shot:
    """Return a photograph."""
    return Shot(
        vehicle='rav1',
        sequence=sequence,
        viewpoint_id=4,
        time_ns=1_700_000_000_123_456_789,
        position=GeoPosition(53.2812345678901, -9.0612345678901, 98.7654321),
        horizontal_std_m=1.5,
        vertical_std_m=2.5,
        height_m=32.1,
        quaternion_xyzw=(0.1, 0.7, 0.7, 0.1),
        width_px=640,
        height_px=480,
        jpeg=jpeg,
    )


def test_record_brings_back_every_bit() -> None:
    """Numbers read back are the numbers written."""
    assert shot_of(shot_record(shot()), shot().jpeg) == shot()


@pytest.mark.parametrize('record', [b'', b'{}', b'[]', b'{"sha256": 3}'])
def test_damaged_record_is_refused(record: bytes) -> None:
    """What is not a record does not become a photograph."""
    with pytest.raises(ValueError, match=r'.'):
        shot_of(record, b'')


def test_record_of_another_image_is_refused() -> None:
    """The hash ties record and image together."""
    with pytest.raises(ValueError, match='sha256'):
        shot_of(shot_record(shot()), b'other')


def test_kept_until_its_own_receipt(tmp_path: Path) -> None:
    """Only a receipt for the same bytes ends the keeping, once."""
    store = ShotStore(tmp_path)
    store.add(shot())
    assert not store.take_receipt('rav1-00000', '0' * 64)
    assert not store.take_receipt('rav1-00001', shot().sha256)
    assert len(store) == 1
    assert store.take_receipt('rav1-00000', shot().sha256)
    assert not store.take_receipt('rav1-00000', shot().sha256)
    assert list(tmp_path.iterdir()) == []


def test_survives_a_kill(tmp_path: Path) -> None:
    """A new process finds the photographs; half-written ones do not count."""
    store = ShotStore(tmp_path)
    store.add(shot(0))
    store.add(shot(1))
    (tmp_path / 'rav1-00002.jpg').write_bytes(b'no record yet')
    (tmp_path / 'rav1-00003.json.part').write_bytes(b'{')
    again = ShotStore(tmp_path)
    assert again.overdue(0.0) == [shot(0), shot(1)]


def test_damaged_spool_is_named(tmp_path: Path) -> None:
    """A record whose image is not its own stops the start, with its path."""
    ShotStore(tmp_path).add(shot())
    (tmp_path / 'rav1-00000.jpg').write_bytes(b'other')
    with pytest.raises(SpoolError, match=r'rav1-00000\.json'):
        ShotStore(tmp_path)


def test_sent_again_after_a_second() -> None:
    """Never sent: due at once; sent: due after RESEND_S; receipted: never."""
    store = ShotStore()
    store.add(shot(0))
    store.add(shot(1))
    store.mark_sent('rav1-00000', 10.0)
    assert store.overdue(10.0) == [shot(1)]
    store.mark_sent('rav1-00001', 10.5)
    assert store.overdue(10.0 + RESEND_S) == [shot(0)]
    store.take_receipt('rav1-00000', shot(0).sha256)
    assert store.overdue(10.5 + RESEND_S) == [shot(1)]


def test_bursts_are_limited() -> None:
    """A receiver that comes back is not flooded."""
    store = ShotStore()
    for sequence in range(3 * RESEND_BURST):
        store.add(shot(sequence))
    assert len(store.overdue(0.0)) == RESEND_BURST


def test_full_spool_gives_up_what_was_sent_longest_ago(tmp_path: Path) -> None:
    """Never what was not sent, however old."""
    store = ShotStore(tmp_path, most_bytes=3 * len(shot().jpeg))
    for sequence in range(3):
        store.add(shot(sequence))
    store.mark_sent('rav1-00001', 5.0)
    store.mark_sent('rav1-00002', 4.0)
    store.add(shot(3))
    assert [kept.shot_id for kept in ShotStore(tmp_path).overdue(0.0)] == [
        'rav1-00000',
        'rav1-00001',
        'rav1-00003',
    ]


def test_spool_full_of_unsent_photographs_refuses_another(tmp_path: Path) -> None:
    """With its size and limit; what is there stays."""
    size = len(shot().jpeg)
    store = ShotStore(tmp_path, most_bytes=size)
    store.add(shot(0))
    with pytest.raises(SpoolError, match=f'spool is full: {size} bytes .* exceed {size}'):
        store.add(shot(1))
    assert len(store) == len(ShotStore(tmp_path)) == 1


def test_photographs_are_brought_to_the_disk(tmp_path: Path, monkeypatch) -> None:
    """File and folder, for the image and for its record."""
    synced = []
    monkeypatch.setattr('rocsafe_geo.storage.durable.os.fsync', synced.append)
    ShotStore(tmp_path).add(shot())
    assert len(synced) == 4
