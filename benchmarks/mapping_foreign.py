# SPDX-License-Identifier: Apache-2.0
"""Runs one foreign tool on a folder of photographs and prints a line: for `mapping.py`.

``python mapping_foreign.py opencv|stitching|pycolmap FOLDER``, our camera centres by image as JSON
on standard input. Needs opencv-python, stitching and pycolmap, which ROCSAFE itself does not use.
"""

import json
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from rocsafe_geo.arrays import FloatArray

Floats = FloatArray
# Camera centre by image, metres.
Centres = dict[str, list[float]]


def main() -> int:
    """Run the tool."""
    tool, folder = sys.argv[1], Path(sys.argv[2])
    ours = json.load(sys.stdin)
    start = time.process_time()
    text = {'opencv': opencv, 'stitching': stitching, 'pycolmap': pycolmap}[tool](folder, ours)
    cpu = time.process_time() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    print(f'{text}, {cpu:.1f} s CPU, {peak} MB')
    return 0


def opencv(folder: Path, _ours: Centres) -> str:
    """OpenCV's Stitcher in mode SCANS."""
    import cv2

    paths = sorted(folder.glob('*.JPG'))
    stitcher = cv2.Stitcher.create(cv2.Stitcher_SCANS)
    status, picture = stitcher.stitch([cv2.imread(str(path)) for path in paths])
    if status != 0:
        return f'failed with status {status}'
    placed = len(stitcher.component())
    return f'{placed} of {len(paths)} placed, {picture.shape[1]} x {picture.shape[0]} pixels'


def stitching(folder: Path, _ours: Centres) -> str:
    """The package stitching with its affine stitcher."""
    from stitching import AffineStitcher

    paths = [str(path) for path in sorted(folder.glob('*.JPG'))]
    try:
        picture = AffineStitcher(detector='sift', confidence_threshold=0.3).stitch(paths)
    except Exception as error:  # noqa: BLE001 - whatever it is, it is the result
        return f'failed: {error}'
    return f'{picture.shape[1]} x {picture.shape[0]} pixels of {len(paths)} images'


def pycolmap(folder: Path, ours: Centres) -> str:
    """Structure from motion with spatial pairs, its centres laid on ours by a similarity."""
    import pycolmap as colmap

    work = Path(tempfile.mkdtemp(prefix='colmap-'))
    database = work / 'database.db'
    extraction = colmap.FeatureExtractionOptions()
    extraction.use_gpu = False
    matching = colmap.FeatureMatchingOptions()
    matching.use_gpu = False
    colmap.extract_features(
        database, folder, camera_mode=colmap.CameraMode.SINGLE, extraction_options=extraction
    )
    colmap.match_spatial(database, matching_options=matching)
    models = colmap.incremental_mapping(database, folder, work / 'sparse')
    model = max(models.values(), key=lambda model: model.num_reg_images())
    pairs = [
        (image.projection_center(), ours[image.name])
        for image in model.images.values()
        if image.name in ours
    ]
    theirs, own = (np.array(side, float) for side in zip(*pairs, strict=True))
    off = own - laid_on(theirs, own)
    rmse = np.sqrt(np.mean(np.sum(off[:, :2] ** 2, axis=1)))
    return f'{len(pairs)} of {len(ours)} placed, our centres {rmse:.2f} m from its'


def laid_on(points: Floats, target: Floats) -> Floats:
    """Return `points` after the similarity that lays them on `target` best (Umeyama 1991)."""
    a, b = points - points.mean(axis=0), target - target.mean(axis=0)
    u, s, vt = np.linalg.svd(b.T @ a)
    sign = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    rotation = u @ sign @ vt
    scale = float(np.trace(np.diag(s) @ sign) / np.sum(a**2))
    laid: Floats = scale * a @ rotation.T + target.mean(axis=0)
    return laid


if __name__ == '__main__':
    sys.exit(main())
