# SPDX-License-Identifier: Apache-2.0
"""Which photograph shows which part of the ground, and the gains that make them alike.

Both are found on a coarse grid, from small pictures of all photographs: the map itself is only
ever in memory by the tile.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.linalg import spsolve

from rocsafe_mapping.alignment.photo import FloatArray
from rocsafe_mapping.drawing.grid import MapGrid, Window
from rocsafe_mapping.drawing.sheet import LATTICE_PX, Shares, Sheet, drawn, scores

# Long side of a footprint on the coarse grid.
COARSE_SIDE_PX = 160
# A seam may leave the line of equal angles where another photograph is this little worse.
SEAM_SLACK = 0.25
# A gain is held to 1 with this share of the weight of what it is compared with, so that it cannot
# drift across the map; the colour of a photograph, its gains over their mean, is held more.
GAIN_HOLD, COLOUR_HOLD = 0.12, 0.5
LARGEST_LOG_GAIN = 1.2
DARK, BRIGHT = 8, 247
LEAST_COMMON_PX = 40
NOBODY = -1
Labels = NDArray[np.int32]


@dataclass(frozen=True, slots=True, kw_only=True)
class CoarseView:
    """A photograph on the coarse grid.

    Attributes
    ----------
    window: where.
    colours: blue, green, red, shape (height, width, 3).
    scores: how well it shows each pixel, 0 where it does not.
    """

    window: Window
    colours: NDArray[np.uint8]
    scores: Shares


def coarse_grid(grid: MapGrid, sheets: Mapping[str, Sheet]) -> tuple[MapGrid, int]:
    """Return the coarse grid and how many pixels of the map one of its pixels is wide."""
    sides = [np.ptp(sheet.corners_m, axis=0).max() for sheet in sheets.values()]
    step = max(1, round(float(np.median(sides)) / COARSE_SIDE_PX / grid.resolution_m))
    coarse = MapGrid(epsg=grid.epsg, resolution_m=grid.resolution_m * step, frame=grid.frame)
    return coarse, step


def coarse_view(sheet: Sheet, image: NDArray[np.uint8], grid: MapGrid) -> CoarseView:
    """Return a photograph on the coarse grid."""
    window = grid.window_of(sheet.corners_m)
    height, width = (-(-side // LATTICE_PX) * LATTICE_PX for side in (window.height, window.width))
    window = Window(window.row, window.column, height, width)
    seen = sheet.seen(grid, window)
    return CoarseView(
        window=window,
        colours=drawn(image, seen, cv2.INTER_LINEAR),
        scores=scores(sheet.photo.camera, seen),
    )


def gains(views: Mapping[str, CoarseView]) -> dict[str, tuple[float, float, float]]:
    """Return factors of blue, green, red for each photograph, by least squares of logarithms."""
    names = sorted(views)
    first, second, ratios, counts = [], [], [], []
    for a, b in _overlapping(names, views):
        ratio = _log_ratio(views[names[a]], views[names[b]])
        if ratio is not None:
            first.append(a)
            second.append(b)
            ratios.append(ratio[0])
            counts.append(ratio[1])
    if not first:
        return dict.fromkeys(names, (1.0, 1.0, 1.0))
    weight = np.array(counts)
    rows = np.arange(len(first))
    design = coo_matrix(
        (np.repeat([1.0, -1.0], len(rows)), (np.tile(rows, 2), np.concatenate([first, second]))),
        shape=(len(rows), len(names)),
    ).tocsr()
    # The brightness of the second over that of the first is to be made up for.
    wanted = np.array(ratios)
    light = wanted.mean(axis=1, keepdims=True)
    common = _held(design, weight, light, GAIN_HOLD)
    logs = common + _held(design, weight, wanted - light, COLOUR_HOLD)
    logs = np.clip(logs, -LARGEST_LOG_GAIN, LARGEST_LOG_GAIN)
    return {name: tuple(np.exp(log).tolist()) for name, log in zip(names, logs, strict=True)}


def _held(design: csr_matrix, weight: FloatArray, wanted: FloatArray, hold: float) -> FloatArray:
    """Return the values (n, k) whose differences are `wanted` but for being held to 0."""
    normal = design.T @ diags(weight) @ design
    normal = (normal + hold * diags(normal.diagonal() + 1.0)).tocsc()
    solved = spsolve(normal, design.T @ (weight[:, np.newaxis] * wanted))
    return np.asarray(solved).reshape(design.shape[1], -1)


def _overlapping(names: list[str], views: Mapping[str, CoarseView]) -> list[tuple[int, int]]:
    """Return the index pairs of views that meet."""
    windows = [views[name].window for name in names]
    boxes = np.array([(w.row, w.column, w.row + w.height, w.column + w.width) for w in windows])
    pairs = []
    for a, box in enumerate(boxes):
        rest = boxes[a + 1 :]
        meets = np.all(rest[:, :2] < box[2:], axis=1) & np.all(box[:2] < rest[:, 2:], axis=1)
        pairs += [(a, a + 1 + int(b)) for b in np.flatnonzero(meets)]
    return pairs


def _log_ratio(first: CoarseView, second: CoarseView) -> tuple[NDArray[np.float64], float] | None:
    """Return log(second / first) of the common colours, and how many pixels tell it."""
    shared = first.window.cut(second.window)
    if shared.is_empty:
        return None
    at_first, at_second = shared.within(first.window), shared.within(second.window)
    one, other = first.colours[at_first], second.colours[at_second]
    usable = (first.scores[at_first] > 0.0) & (second.scores[at_second] > 0.0)
    for colours in (one, other):
        usable &= np.all((colours > DARK) & (colours < BRIGHT), axis=2)
    count = int(usable.sum())
    if count < LEAST_COMMON_PX:
        return None
    ratio = np.log(other[usable].astype(np.float32)) - np.log(one[usable].astype(np.float32))
    return np.median(ratio, axis=0).astype(np.float64), float(np.sqrt(count))


def owners(views: Mapping[str, CoarseView], names: list[str], window: Window) -> Labels:
    """Return the index in `names` of the photograph that each coarse pixel shows, or -1.

    Near the lines where two photographs show the ground equally well the border is moved to where
    they look alike, by dynamic programming (Uyttendaele et al. 2001), so that it runs round what
    stands up.
    """
    best = np.zeros((window.height, window.width), np.float32)
    second = np.zeros_like(best)
    for name in names:
        view = views[name]
        part = view.window.within(window)
        np.maximum(second[part], np.minimum(best[part], view.scores), out=second[part])
        np.maximum(best[part], view.scores, out=best[part])
    masks, pictures, corners = [], [], []
    for name in names:
        view = views[name]
        part = view.window.within(window)
        # Only the two best compete: where many overlap, the others are no better a choice.
        least = np.maximum(best[part] * (1.0 - SEAM_SLACK), second[part])
        is_near = (view.scores > 0.0) & (view.scores >= least)
        masks.append(np.where(is_near, 255, 0).astype(np.uint8))
        pictures.append(view.colours)
        corners.append((view.window.column, view.window.row))
    cut = _cut(pictures, corners, masks)
    labels = np.full((window.height, window.width), NOBODY, np.int32)
    found = np.zeros((window.height, window.width), np.float32)
    for is_cut in (True, False):
        for number, name in enumerate(names):
            view = views[name]
            part = view.window.within(window)
            open_to = (view.scores > found[part]) & (labels[part] == NOBODY)
            if is_cut:
                open_to = (cut[number] > 0) & (view.scores > found[part])
            labels[part][open_to] = number
            found[part][open_to] = view.scores[open_to]
    return labels


def _cut(
    pictures: list[NDArray[np.uint8]],
    corners: list[tuple[int, int]],
    masks: list[NDArray[np.uint8]],
) -> list[NDArray[np.uint8]]:
    if len(pictures) < 2:
        return masks
    # The stubs of OpenCV know no arrays here.
    finder: Any = cv2.detail_DpSeamFinder('COLOR')  # type: ignore[attr-defined]
    cut = finder.find(pictures, corners, masks)
    return [mask.get() if isinstance(mask, cv2.UMat) else mask for mask in cut]
