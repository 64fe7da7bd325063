# SPDX-License-Identifier: Apache-2.0
"""A real disk that is full: a small tmpfs."""

import hashlib

import numpy as np
import pytest
from test.small_file_system import small_file_system

from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.store.catalogue import MANIFEST, entry_of_line, read_store
from rocsafe_mapping.store.store import ImageStore, Status


@pytest.fixture
def small_disk(tmp_path):
    """A file system of two megabytes."""
    with small_file_system(tmp_path / 'disk', megabytes=2) as folder:
        yield folder


def large_shot(shot, number):
    """Return a photograph of about 100 kB."""
    import cv2

    pixels = np.random.default_rng(number).integers(0, 256, (240, 320, 3)).astype(np.uint8)
    image = bytes(cv2.imencode('.jpg', pixels, [cv2.IMWRITE_JPEG_QUALITY, 95])[1])
    record, image = shot(number, image)
    return record, image


@pytest.mark.parametrize('reserve_bytes', [-(2**40), 512 * 1024])
def test_a_full_disk_is_one_clear_error_and_loses_nothing(small_disk, shot, reserve_bytes):
    """From the kernel where the store does not look, else from the store; nothing is torn."""
    store = ImageStore(small_disk / 'images', reserve_bytes=reserve_bytes)
    stored = {}
    message = 'No space left on device' if reserve_bytes < 0 else 'as good as full'
    with pytest.raises(StoreError, match=message):  # noqa: PT012 - the last of many
        for number in range(100):
            record, image = large_shot(shot, number)
            assert store.put(record, image).status is Status.STORED
            stored[record.shot_id] = image
    store.close()
    assert len(stored) > 2
    # A photograph that lacked nothing but its line in the manifest may be adopted.
    again = ImageStore(small_disk / 'images', reserve_bytes=reserve_bytes)
    count = len(again)
    again.close()
    assert len(stored) <= count <= len(stored) + 1
    lines = (small_disk / 'images' / MANIFEST).read_bytes().splitlines()
    hashes = {entry.shot_id: entry.stored_sha256 for entry in map(entry_of_line, lines)}
    for kept in read_store(small_disk / 'images', pytest.fail):
        sha256 = hashlib.sha256(kept.read_image()).hexdigest()
        assert hashes[kept.record.shot_id] == sha256
        stored.pop(kept.record.shot_id, None)
    assert not stored
