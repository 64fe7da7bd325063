# SPDX-License-Identifier: Apache-2.0
"""Which photograph shows which part of the ground: borders where two of them agree."""

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.drawing.coarse_view import NO_PHOTO, CoarseView, Labels, overlapping
from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.object_ownership import keep_objects_whole
from rocsafe_mapping.drawing.placed_photo import Shares
from rocsafe_mapping.drawing.seam_cost import seam_cost
from rocsafe_mapping.drawing_options import DrawingOptions, SeamOptions

Mask = NDArray[np.uint8]
Place = tuple[slice, slice]


def owners(
    views: Mapping[str, CoarseView], names: list[str], window: Window, options: DrawingOptions
) -> Labels:
    """Return the index in `names` of the photograph that each coarse pixel shows, or -1.

    Near the line where two photographs show the ground equally well, the border is moved to where
    they agree: it runs round objects. An object that it still cuts is given to one photograph,
    where one shows it whole.
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
        # Only the photographs with the two best scores are candidates where many overlap.
        least = np.maximum(best[part] * (1.0 - options.seams.slack), second[part])
        is_near = (view.scores > 0.0) & (view.scores >= least)
        masks.append(np.where(is_near, 255, 0).astype(np.uint8))
    cost = _cut(shown, masks, window, options.seams)
    labels = np.full((window.height, window.width), NO_PHOTO, np.int32)
    found = np.zeros((window.height, window.width), np.float32)
    for is_cut in (True, False):
        for number, view in enumerate(shown):
            part = view.window.within(window)
            open_to = (view.scores > found[part]) & (labels[part] == NO_PHOTO)
            if is_cut:
                open_to = (masks[number] > 0) & (view.scores > found[part])
            labels[part][open_to] = number
            found[part][open_to] = view.scores[open_to]
    keep_objects_whole(labels, cost, shown, window, options)
    return labels


def _cut(
    shown: list[CoarseView], masks: list[Mask], window: Window, options: SeamOptions
) -> Shares:
    """Divide the masks where candidates overlap; return the cost of seams in `window`.

    Distant photographs are divided first; then only neighbours overlap.
    """
    cost = np.zeros((window.height, window.width), np.float32)
    boxes = [view.window for view in shown]
    middles = np.array([(box.row + box.height / 2, box.column + box.width / 2) for box in boxes])
    pairs = overlapping(boxes)
    for a, b in sorted(pairs, key=lambda ab: -np.sum((middles[ab[0]] - middles[ab[1]]) ** 2)):
        shared = boxes[a].cut(boxes[b])
        parts = shared.within(boxes[a]), shared.within(boxes[b])
        if np.any((masks[a][parts[0]] > 0) & (masks[b][parts[1]] > 0)):
            found = _cost(shown[a], shown[b], parts, options)
            at = shared.within(window)
            np.maximum(cost[at], found, out=cost[at])
            cost_with_length = found + np.float32(options.search_length_cost)
            _part((masks[a], masks[b]), (boxes[a], boxes[b]), cost_with_length, parts[1])
    return cost


def _cost(
    first: CoarseView, second: CoarseView, parts: tuple[Place, Place], options: SeamOptions
) -> Shares:
    """Return the cost of a seam where two photographs meet; nothing where one shows nothing."""
    one, other = first.colours[parts[0]], second.colours[parts[1]]
    is_seen = (first.scores[parts[0]] > 0.0) & (second.scores[parts[1]] > 0.0)
    return seam_cost(one, np.where(is_seen[..., np.newaxis], other, one), options)


def _part(masks: tuple[Mask, Mask], boxes: tuple[Window, Window], cost: Shares, at: Place) -> None:
    """Divide two masks by dynamic programming (Uyttendaele et al. 2001)."""
    # The finder's costs are the squared differences of pictures.
    pictures = [np.zeros((*mask.shape, 3), np.float32) for mask in masks]
    pictures[1][at[0], at[1], 0] = np.sqrt(cost)
    # The stubs of OpenCV know no arrays here.
    finder: Any = cv2.detail_DpSeamFinder('COLOR')  # type: ignore[attr-defined]
    cut = finder.find(pictures, [(box.column, box.row) for box in boxes], list(masks))
    for mask, found in zip(masks, cut, strict=True):
        mask[...] = found.get() if isinstance(found, cv2.UMat) else found
