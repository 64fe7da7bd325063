# SPDX-License-Identifier: Apache-2.0
"""The case of processes that are killed."""

import argparse
import hashlib
import os
import shutil
import signal
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from mapping_figures import (
    Row,
    real_ground,
)
from mapping_sets import (
    Flight,
    flown,
)

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.model.photo import footprint
from rocsafe_mapping.live.live_map import LiveMap
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.store.catalogue import read_store
from rocsafe_mapping.store.store import ImageStore, Status

Shot = tuple[ShotRecord, bytes]


def kill(options: argparse.Namespace) -> list[Row]:
    """Collector and mosaic killed at random points."""
    ground = real_ground(options)
    samples = flown(ground, Flight(extent_m=(70.0, 55.0)), 51)
    shots = [(replace(s.record, sha256=hashlib.sha256(s.jpeg).hexdigest()), s.jpeg)
             for s in samples]  # fmt: skip
    folder = Path(tempfile.mkdtemp(prefix='kill-'))
    rng = np.random.default_rng(1)
    lost, kills = 0, 0
    whole_s = _stored_until(folder / 'whole', folder / 'whole.txt', shots, None)
    for number in range(100):
        place, receipts = folder / str(number), folder / f'{number}.txt'
        _stored_until(place, receipts, shots, float(rng.uniform(0.0, whole_s)))
        known = receipts.read_text().split() if receipts.exists() else []
        store = ImageStore(place, reserve_bytes=0)
        states = {record.shot_id: store.put(record, jpeg).status for record, jpeg in shots}
        store.close()
        kills += len(known) < len(shots)
        lost += sum(states[name] is not Status.DUPLICATE for name in known)
        shutil.rmtree(place)
    first = _poses(folder / 'whole')
    off_px = 0.0
    for _ in range(options.mosaic_kills):
        _mapped_until(folder / 'whole', float(rng.uniform(0.2, 3.0)))
        again = _poses(folder / 'whole')
        off_px = max(off_px, *(float(np.abs(again[n] - first[n]).max()) for n in first))
    return [
        ('collector killed at 100 random points', (f'{kills} before its end, {lost} acknowledged '
         'images lost'), '0 lost'),
        (f'mosaic killed at {options.mosaic_kills} random points, resumed',
         f'corners differ by {off_px:.4f} px', '<= 0.05 px'),
    ]  # fmt: skip


def _stored_until(
    place: Path, receipts: Path, shots: Sequence[Shot], kill_s: float | None
) -> float:
    """Store photographs in a process that is killed after a time; return how long it ran."""
    start = time.perf_counter()
    child = os.fork()
    if child == 0:
        store = ImageStore(place, reserve_bytes=0)
        with receipts.open('wb', buffering=0) as file:
            for record, jpeg in shots:
                store.put(record, jpeg)
                file.write(record.shot_id.encode() + b'\n')
        os._exit(0)
    if kill_s is not None:
        time.sleep(kill_s)
        os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return time.perf_counter() - start


def _mapped_until(place: Path, kill_s: float) -> None:
    """Map a store live in a process that is killed after a time."""
    child = os.fork()
    if child == 0:
        growing = LiveMap(MapOptions(ground_resolution_m=0.1), place / 'tiles', print)
        for shot in read_store(place, print):
            growing.receive(shot.record, shot.read_image)
            growing.release_tiles()
            while growing.work():
                pass
        os._exit(0)
    time.sleep(kill_s)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)


def _poses(place: Path) -> dict[str, FloatArray]:
    """Return the corners of the photographs of a store, in pixels of the photographs."""
    maker = Mapmaker(MapOptions())
    for shot in read_store(place, print):
        maker.add(shot.record, shot.read_image)
    alignment = maker.align()
    return {
        name: footprint(alignment.photos[name], placement.pose)
        / alignment.photos[name].ground_resolution_m
        for name, placement in alignment.placements.items()
    }
