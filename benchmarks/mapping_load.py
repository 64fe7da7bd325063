# SPDX-License-Identifier: Apache-2.0
"""Cases of load: many photographs, and photographs that come in."""

import argparse
import dataclasses
import json
import math
import os
import pickle
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mapping_figures import (
    Row,
    mapped,
    on_disk,
    peak_mb,
    real_ground,
    stages,
)
from mapping_sets import (
    Flight,
    enlarged,
    flown,
)

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.allocation import keep_freed_memory
from rocsafe_mapping.command_line.map_command import Stopwatch
from rocsafe_mapping.live.live_map import TILES_S, LiveMap
from rocsafe_mapping.mosaic.mapmaker import MapOptions
from rocsafe_mapping.products.map_products import ProductOptions, write_products

SET = 'set.pickle'


def scale(options: argparse.Namespace) -> list[Row]:
    """A thousand photographs of 1600 pixels."""
    rows: list[Row] = []
    per_image = []
    for count, extent in ((100, (250.0, 185.0)), (options.count, (780.0, 590.0))):
        made = _mapped_apart(_large_set(options, count, extent))
        per_image.append(made['cpu_s'] / made['total'])
        figures = (
            f'{made["wall_s"]:.0f} s, {made["cpu_s"]:.0f} s CPU, {made["peak_mb"]} MB, '
            f'{made["tied"]} tied, internal {made["internal_m"]:.3f} m'
        )
        target = '<= 15 min on 2 cores, <= 1000 MB' if count > 100 else ''
        rows.append((f'{made["total"]} images of 1600 px', figures, target))
        rows.append(('CPU seconds of its stages', made['stages'], ''))
    change = 100.0 * (per_image[1] / per_image[0] - 1.0)
    return [*rows, ('CPU per image, change from 100', f'{change:+.0f} %', 'within 20 %')]


def _large_set(options: argparse.Namespace, count: int, extent_m: tuple[float, float]) -> Path:
    """Return the folder of a set of photographs of 1600 pixels, made once."""
    folder = Path(tempfile.gettempdir()) / f'rocsafe-benchmark-scale-{count}'
    if not (folder / SET).exists():
        folder.mkdir(exist_ok=True)
        ground = enlarged(real_ground(options), 4, 3)
        camera = PinholeCamera(math.radians(60.0), 1600, 1200)
        flight = Flight(camera=camera, extent_m=extent_m)
        samples = [on_disk(sample, folder) for sample in flown(ground, flight, 31, count)]
        (folder / SET).write_bytes(pickle.dumps(samples))
    return folder


def live(options: argparse.Namespace) -> list[Row]:
    """Sixty images a minute."""
    ground = enlarged(real_ground(options), 2, 3)
    flight = Flight(extent_m=(250.0, 185.0))
    samples = flown(ground, flight, 41, 100)
    period_s = 60.0 / options.rate
    folder = Path(tempfile.mkdtemp(prefix='live-'))
    growing = LiveMap(MapOptions(ground_resolution_m=0.1), folder / 'tiles', print)
    shown, refined, queue = [], [], []
    start = time.perf_counter()
    cpu = time.process_time()
    landed: dict[str, float] = {}
    waiting, released = list(samples), 0.0
    while waiting or growing.is_busy:
        now = time.perf_counter() - start
        if now >= released + TILES_S:
            growing.release_tiles()
            released = now
        if waiting and now >= period_s * (len(samples) - len(waiting)):
            sample = waiting.pop(0)
            name = sample.record.shot_id
            landed[name] = period_s * (len(samples) - len(waiting) - 1)
            growing.receive(sample.record, partial(getattr, sample, 'jpeg'))
            growing.preview.png()
            shown.append(time.perf_counter() - start - landed[name])
            queue.append(name)
        elif growing.work():
            placed = growing.maker.block.state.poses
            for name in [name for name in queue if name in placed]:
                refined.append(time.perf_counter() - start - landed[name])
                queue.remove(name)
        else:
            time.sleep(0.005)
    busy = (time.process_time() - cpu) / (time.perf_counter() - start)
    wall = time.perf_counter()
    watch = Stopwatch()
    growing.finish()
    watch.lap('finish')
    alignment = growing.maker.align(watch.lap)
    wanted = ProductOptions(geotiff=folder / 'm.tif', folder=folder)
    write_products(growing.maker, alignment, wanted, watch.lap)
    final = time.perf_counter() - wall
    growing.close()
    p95 = float(np.quantile(refined, 0.95))
    return [
        (f'live, {options.rate:.0f} images a minute: shown',
         f'p50 {np.median(shown):.2f} s, largest {max(shown):.2f} s', '<= 1 s'),
        ('live: refined', (f'p50 {np.median(refined):.2f} s, p95 {p95:.2f} s, '
         f'largest {max(refined):.2f} s, {len(refined)} of {len(samples)}'), '<= 3 s'),
        ('live: share of one core used', f'{100 * busy:.0f} %', 'no growing queue'),
        ('live: final map after the last image', f'{final:.1f} s', '<= 10 s'),
        ('live: CPU seconds of its stages', stages(watch), ''),
    ]  # fmt: skip


def _mapped_apart(folder: Path) -> dict[str, Any]:
    """Map a set in a process of its own, whose memory is its own."""
    code = (
        'import sys; sys.path.insert(0, sys.argv[2]); '
        'import mapping_load; mapping_load.apart(sys.argv[1])'
    )
    done = subprocess.run(
        [sys.executable, '-c', code, str(folder), str(Path(__file__).parent)],
        capture_output=True, text=True, check=True, timeout=1800, env=os.environ,
    )  # fmt: skip
    found: dict[str, Any] = json.loads(done.stdout.strip().splitlines()[-1])
    return found


def apart(folder: str) -> None:
    """Map the pickled set of a folder and print figures: the other end of `_mapped_apart`."""
    keep_freed_memory()
    samples = pickle.loads((Path(folder) / SET).read_bytes())  # noqa: S301 - our own
    made = mapped(samples, LocalFrame(GeoPosition(53.28, -9.06, 60.0)), 0.05, draw=True)
    print(json.dumps(dataclasses.asdict(made) | {'peak_mb': peak_mb()}))
