# SPDX-License-Identifier: Apache-2.0
"""A map maker that is killed at any moment leaves whole files, and the next makes the same map.

``ROCSAFE_MOSAIC_KILLS=100`` kills more often.
"""

import hashlib
import importlib.util
import json
import os
import pathlib
import random
import subprocess
import sys
import threading
import time
from dataclasses import replace

import cv2
import pytest
import rasterio

from rocsafe_mapping.store.store import ImageStore, Status

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)

KILLS = int(os.environ.get('ROCSAFE_MOSAIC_KILLS', '3'))
CHILD = pathlib.Path(__file__).with_name('mosaic_child.py')
DEADLINE_S = 120.0
# Files that are being written have these endings, and nobody takes them for a map.
UNFINISHED = ('.part', '.raw', '.tmp')


@pytest.fixture(scope='module')
def store(tmp_path_factory):
    """A store with the photographs of a flight."""
    folder = tmp_path_factory.mktemp('kills') / 'images'
    images = ImageStore(folder, reserve_bytes=0)
    for shot in texture.flight(1):
        record = replace(shot.record, sha256=hashlib.sha256(shot.jpeg).hexdigest())
        assert images.put(record, shot.jpeg).status is Status.STORED
    images.close()
    return folder


def made(store, folder, kill_s=None):
    """Make the map in a process of its own, killed after a time; return how long it worked."""
    child = subprocess.Popen(
        [sys.executable, str(CHILD), str(store), str(folder)], stdout=subprocess.PIPE
    )
    watchdog = threading.Timer(DEADLINE_S, child.kill)
    watchdog.start()
    try:
        assert child.stdout.readline() == b'begin\n'
        start = time.monotonic()
        if kill_s is not None:
            try:
                child.wait(kill_s)
            except subprocess.TimeoutExpired:
                child.kill()
        child.wait()
        return time.monotonic() - start
    finally:
        watchdog.cancel()
        child.stdout.close()


def check_whole(folder):
    """Fail unless each file that is there can be read to its end."""
    for path in folder.rglob('*'):
        if path.suffix == '.png':
            assert cv2.imread(str(path), cv2.IMREAD_UNCHANGED) is not None, path
        elif path.suffix == '.json':
            json.loads(path.read_text())
        elif path.suffix == '.tif':
            with rasterio.open(path) as file:
                file.read()
        else:
            assert path.is_dir() or path.suffix in (*UNFINISHED, '.html', '.kml', '.pgw', '.prj')


@pytest.mark.timeout(300 + 30 * KILLS)
@pytest.mark.all
def test_a_killed_map_maker_leaves_whole_files_and_the_next_makes_the_same_map(store, tmp_path):
    """At random moments of its work; the GeoTIFF is the same to the byte in the end."""
    duration_s = made(store, tmp_path / 'whole')
    wanted = (tmp_path / 'whole' / 'm.tif').read_bytes()
    moments = random.Random(1)
    for _ in range(KILLS):
        made(store, tmp_path / 'killed', moments.uniform(0.0, duration_s))
        check_whole(tmp_path / 'killed')
    made(store, tmp_path / 'killed')
    check_whole(tmp_path / 'killed')
    assert (tmp_path / 'killed' / 'm.tif').read_bytes() == wanted
    left = {path.suffix for path in (tmp_path / 'killed').rglob('*')}
    assert not left & set(UNFINISHED)
