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

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.drawing.grid import MapGrid, Window
from rocsafe_mapping.drawing.labels import NOBODY, Labels
from rocsafe_mapping.drawing.seam_cost import SEARCH_LENGTH_COST, seam_cost
from rocsafe_mapping.drawing.sheet import LATTICE_PX, Shares, Sheet, drawn, scores
from rocsafe_mapping.drawing.whole_things import keep_whole

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
Mask = NDArray[np.uint8]
Place = tuple[slice, slice]


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
    for a, b in _overlapping([views[name].window for name in names]):
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


def _overlapping(windows: list[Window]) -> list[tuple[int, int]]:
    """Return the index pairs of windows that meet."""
    boxes = np.array([(w.row, w.column, w.row + w.height, w.column + w.width) for w in windows])
    pairs = []
    for a, box in enumerate(boxes):
        rest = boxes[a + 1 :]
        meets = np.all(rest[:, :2] < box[2:], axis=1) & np.all(box[:2] < rest[:, 2:], axis=1)
        pairs += [(a, a + 1 + int(b)) for b in np.flatnonzero(meets)]
    return pairs


def _log_ratio(first: CoarseView, second: CoarseView) -> tuple[FloatArray, float] | None:
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
    they agree, so that it runs round what stands up; what it would still cut is shown whole by one
    photograph where that is possible.
    """
    best = np.zeros((window.height, window.width), np.float32)
    second = np.zeros_like(best)
    for name in names:
        view = views[name]
        part = view.window.within(window)
        np.maximum(second[part], np.minimum(best[part], view.scores), out=second[part])
        np.maximum(best[part], view.scores, out=best[part])
    shown = [views[name] for name in names]
    masks = []
    for view in shown:
        part = view.window.within(window)
        # Only the two best compete: where many overlap, the others are no better a choice.
        least = np.maximum(best[part] * (1.0 - SEAM_SLACK), second[part])
        is_near = (view.scores > 0.0) & (view.scores >= least)
        masks.append(np.where(is_near, 255, 0).astype(np.uint8))
    cost = _cut(shown, masks, window)
    labels = np.full((window.height, window.width), NOBODY, np.int32)
    found = np.zeros((window.height, window.width), np.float32)
    for is_cut in (True, False):
        for number, view in enumerate(shown):
            part = view.window.within(window)
            open_to = (view.scores > found[part]) & (labels[part] == NOBODY)
            if is_cut:
                open_to = (masks[number] > 0) & (view.scores > found[part])
            labels[part][open_to] = number
            found[part][open_to] = view.scores[open_to]
    keep_whole(labels, cost, shown, window)
    return labels


def _cut(shown: list[CoarseView], masks: list[Mask], window: Window) -> Shares:
    """Part the masks of photographs that compete; return the cost of seams in `window`.

    Photographs far from each other come first: what is left is between neighbours.
    """
    cost = np.zeros((window.height, window.width), np.float32)
    boxes = [view.window for view in shown]
    middles = np.array([(box.row + box.height / 2, box.column + box.width / 2) for box in boxes])
    pairs = _overlapping(boxes)
    for a, b in sorted(pairs, key=lambda ab: -np.sum((middles[ab[0]] - middles[ab[1]]) ** 2)):
        shared = boxes[a].cut(boxes[b])
        parts = shared.within(boxes[a]), shared.within(boxes[b])
        if np.any((masks[a][parts[0]] > 0) & (masks[b][parts[1]] > 0)):
            found = _cost(shown[a], shown[b], parts)
            at = shared.within(window)
            np.maximum(cost[at], found, out=cost[at])
            _part((masks[a], masks[b]), (boxes[a], boxes[b]), found, parts[1])
    return cost


def _cost(first: CoarseView, second: CoarseView, parts: tuple[Place, Place]) -> Shares:
    """Return the cost of a seam where two photographs meet; nothing where one shows nothing."""
    one, other = first.colours[parts[0]], second.colours[parts[1]]
    is_seen = (first.scores[parts[0]] > 0.0) & (second.scores[parts[1]] > 0.0)
    return seam_cost(one, np.where(is_seen[..., np.newaxis], other, one))


def _part(masks: tuple[Mask, Mask], boxes: tuple[Window, Window], cost: Shares, at: Place) -> None:
    """Part two masks by dynamic programming (Uyttendaele et al. 2001)."""
    # The finder's costs are the squared differences of pictures.
    pictures = [np.zeros((*mask.shape, 3), np.float32) for mask in masks]
    pictures[1][at[0], at[1], 0] = np.sqrt(cost + np.float32(SEARCH_LENGTH_COST))
    # The stubs of OpenCV know no arrays here.
    finder: Any = cv2.detail_DpSeamFinder('COLOR')  # type: ignore[attr-defined]
    cut = finder.find(pictures, [(box.column, box.row) for box in boxes], list(masks))
    for mask, found in zip(masks, cut, strict=True):
        mask[...] = found.get() if isinstance(found, cv2.UMat) else found
