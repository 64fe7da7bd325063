# SPDX-License-Identifier: Apache-2.0
"""Objects that seams cut are given to one photograph each.

A seam can run round an object only within the overlap of two photographs. An object that is too
wide for that may be whole in one photograph: this one then shows it, also where another looks more
steeply down.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from rocsafe_geo.arrays import BoolArray
from rocsafe_mapping.drawing.coarse_view import NO_PHOTO, CoarseView, Labels
from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.placed_photo import Shares
from rocsafe_mapping.drawing_options import DrawingOptions

AROUND = np.ones((3, 3), np.uint8)
Mask = BoolArray
Place = tuple[slice, slice]


def keep_objects_whole(
    labels: Labels,
    cost: Shares,
    views: Sequence[CoarseView],
    window: Window,
    options: DrawingOptions,
) -> None:
    """Give objects that seams cut to one photograph each, in `labels`, where that costs less.

    Parameters
    ----------
    labels
        Index in `views` of who is shown at each pixel of `window`, changed here.
    cost
        Of a seam through each pixel.
    """
    # A seam keeps a pixel off an object.
    cost = cv2.dilate(cost, AROUND)
    for least, width in options.objects.rounds:
        for place, is_thing in _things(labels, cost > least, width, options.objects.margin_px):
            row, column = window.row + place[0].start, window.column + place[1].start
            box = Window(row, column, *is_thing.shape)
            # Only photographs shown about the object are candidates: the cost beside others is
            # unknown.
            near = set(np.unique(labels[place]).tolist()) - {NO_PHOTO}
            scores = {number: _scores(views[number], box) for number in sorted(near)}
            labels[place] = _best(labels[place], cost[place], is_thing, scores, options)


def _things(labels: Labels, stands: Mask, width: int, margin_px: int) -> list[tuple[Place, Mask]]:
    """Return the objects that more than one photograph shows, each with its place."""
    opened = cv2.morphologyEx(
        stands.astype(np.uint8), cv2.MORPH_OPEN, np.ones((width, width), np.uint8)
    )
    count, numbers, boxes, _ = cv2.connectedComponentsWithStats(cv2.dilate(opened, AROUND))
    found = []
    for number in range(1, count):
        column, row, box_width, box_height = boxes[number, :4].tolist()
        place = (
            slice(max(row - margin_px, 0), row + box_height + margin_px),
            slice(max(column - margin_px, 0), column + box_width + margin_px),
        )
        is_thing = numbers[place] == number
        about = cv2.dilate(is_thing.astype(np.uint8), AROUND, iterations=2) > 0
        if np.ptp(labels[place][about]) > 0:
            found.append((place, is_thing))
    return found


def _scores(view: CoarseView, box: Window) -> Shares:
    """Return how well a photograph shows each pixel of `box`."""
    found = np.zeros((box.height, box.width), np.float32)
    shared = view.window.cut(box)
    found[shared.within(box)] = view.scores[shared.within(view.window)]
    return found


def _best(
    labels: Labels,
    cost: Shares,
    is_thing: Mask,
    scores: dict[int, Shares],
    options: DrawingOptions,
) -> Labels:
    """Return the labels of a place, those of the object changed if that lowers the cost."""
    objects, length_cost = options.objects, options.seams.kept_length_cost
    best, least = labels, objects.whole_share * _seams_cost(labels, cost, length_cost)
    for number, score in scores.items():
        taken = is_thing & (score > objects.least_score)
        changed = np.where(taken, np.int32(number), labels)
        total = _seams_cost(changed, cost, length_cost) - objects.score_worth * float(
            score[taken].sum()
        )
        if total < least:
            best, least = changed, total
    return best


def _seams_cost(labels: Labels, cost: Shares, length_cost: float) -> float:
    """Return what all seams between neighbouring pixels cost."""
    total = 0.0
    for lines, prices in ((labels, cost), (labels.T, cost.T)):
        is_seam = lines[1:] != lines[:-1]
        total += float(np.sum((prices[1:] + prices[:-1])[is_seam]))
        total += 2.0 * length_cost * int(is_seam.sum())
    return total
