# SPDX-License-Identifier: Apache-2.0
"""What a set of photographs comes to: figures beside the truth, as rows of a table."""

import argparse
import math
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from mapping_sets import (
    OnDisk,
    Orthophoto,
    Sample,
    enlarged,
    orthophoto,
)

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_mapping.alignment.block import BY_FEATURES
from rocsafe_mapping.command_line.map_command import Stopwatch
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions, Shot
from rocsafe_mapping.products.map_products import ProductOptions, write_products
from rocsafe_mapping.products.quality import violations
from rocsafe_mapping.store.photograph_files import photographs_of

Row = tuple[str, str, str]


@dataclass(frozen=True, slots=True)
class Measured:
    """What came of a set of photographs."""

    total: int
    tied: int
    median_px: float
    rmse_px: float
    absolute_m: float
    internal_m: float
    stated_m: float
    cpu_s: float
    wall_s: float
    refused: str
    stages: str = ''


def mapped(
    samples: Sequence[Sample | OnDisk],
    frame: LocalFrame,
    resolution_m: float = 0.0,
    *,
    draw: bool = False,
) -> Measured:
    """Align (and draw) a set and compare it with its truth."""
    wall, cpu = time.perf_counter(), time.process_time()
    watch = Stopwatch()
    maker = Mapmaker(MapOptions(ground_resolution_m=resolution_m))
    for sample in samples:
        maker.add(sample.record, partial(getattr, sample, 'jpeg'))
    alignment = maker.align(watch.lap)
    if draw:
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder)
            wanted = ProductOptions(geotiff=place / 'm.tif', folder=place, with_overlays=False)
            write_products(maker, alignment, wanted, watch.lap)
    cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
    found, true = [], []
    if maker.frame is None:
        raise ValueError('no photograph could be placed')
    origin = frame.enu_of(maker.frame.frame.origin)[:2]
    placed_photos = maker.placed_photos()
    for sample in samples:
        name = sample.record.shot_id
        if name in placed_photos:
            found.append(placed_photos[name].corners_m + origin)
            true.append(sample.corners_m)
    off = np.linalg.norm(alignment.held_out_px, axis=1)
    states = [placement.placed_by for placement in alignment.placements.values()]
    stated = [alignment.error_m(name) ** 2 for name in alignment.photos]
    return Measured(
        total=len(samples),
        tied=states.count(BY_FEATURES),
        median_px=float(np.median(off)) if len(off) else math.nan,
        rmse_px=float(np.sqrt(np.mean(off**2))) if len(off) else math.nan,
        absolute_m=rms_m(np.concatenate(found) - np.concatenate(true)),
        internal_m=internal(np.concatenate(found), np.concatenate(true)),
        stated_m=math.sqrt(float(np.mean(stated))),
        cpu_s=cpu,
        wall_s=wall,
        refused='; '.join(violations(alignment, maker.block.state)),
        stages=stages(watch),
    )


def rows_of(name: str, made: Measured, **targets: float) -> list[Row]:
    """Return rows of the figures that have targets."""
    figures: dict[str, tuple[float, str]] = {
        'median': (made.median_px, 'held-out median, px'),
        'rmse': (made.rmse_px, 'held-out RMSE, px'),
        'internal': (made.internal_m, 'internal error, m'),
        'absolute': (made.absolute_m, 'absolute error, m'),
    }
    rows = [(f'{name}: placed by features', f'{made.tied} of {made.total}',
             f'>= {100 * targets.pop("tied"):.0f} %')]  # fmt: skip
    for key, limit in targets.items():
        value, title = figures[key]
        rows.append((f'{name}: {title}', f'{value:.3f}', f'<= {limit:g}'))
    rows.append((f'{name}: stated error, m', f'{made.stated_m:.3f}', ''))
    return rows


def real_ground(options: argparse.Namespace) -> Orthophoto:
    """Return real ground: the map of brighton_beach, made once."""
    folder = Path(tempfile.gettempdir()) / 'rocsafe-benchmark-ground'
    picture = folder / 'm.png'
    if not picture.exists():
        maker = Mapmaker(MapOptions(ground_resolution_m=0.05))
        maker.add_all(
            [
                Shot(name=shot.path.name, record=shot.record, read=shot.read_image)
                for shot in photographs_of(options.data / 'brighton_beach', print)
            ]
        )
        renderer_folder = ProductOptions(
            geotiff=folder / 'm.tif', folder=folder, with_overlays=False
        )
        write_products(maker, maker.align(), renderer_folder)
        import rasterio
        import rasterio.shutil

        rasterio.shutil.copy(folder / 'm.tif', picture, driver='PNG')
    return enlarged(orthophoto(picture, 0.05), 3, 3)


def on_disk(sample: Sample, folder: Path) -> OnDisk:
    """Write the photograph of a sample to a folder; return the sample without its bytes."""
    path = folder / f'{sample.record.shot_id}.jpg'
    path.write_bytes(sample.jpeg)
    return OnDisk(sample.record, path, sample.corners_m)


def internal(found: FloatArray, true: FloatArray) -> float:
    """Return the RMS distance after the best similarity."""
    a, b = found @ [1, 1j], true @ [1, 1j]
    a, b = a - a.mean(), b - b.mean()
    factor = np.vdot(a, b) / np.vdot(a, a)
    return float(np.sqrt(np.mean(np.abs(factor * a - b) ** 2)))


def stages(watch: Stopwatch) -> str:
    """Return the processor seconds of each stage."""
    return ', '.join(f'{name} {cost["cpu_s"]:.1f}' for name, cost in watch.costs.items())


def p95(values: FloatArray) -> float:
    """Return the 95 % quantile, NaN of nothing."""
    return float(np.quantile(values, 0.95)) if len(values) else math.nan


def rms_m(off: FloatArray) -> float:
    """Return the root mean square length of vectors (n, 2)."""
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def peak_mb() -> int:
    """Return the peak memory of this process, MiB, without that of the one which started it.

    `ru_maxrss` begins with the memory that a process had before it ran its own program.
    """
    status = Path('/proc/self/status').read_text(encoding='ascii')
    (peak_kb,) = (line.split()[1] for line in status.splitlines() if line.startswith('VmHWM'))
    return int(peak_kb) // 1024


def root_mean(values: FloatArray) -> float:
    """Return the root of the mean of squares."""
    return float(np.sqrt(np.mean(values**2)))
