# SPDX-License-Identifier: Apache-2.0
"""Things that stand up shown whole, by one photograph each, where seams would cut them.

A seam that runs round a thing can do so only within what two neighbours both show. A thing that
is too wide for that may still be whole in one of the photographs: then this one shows it, also
where another looks more steeply down.
"""

from collections.abc import Sequence
from typing import Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.labels import NOBODY, Labels
from rocsafe_mapping.drawing.seam_cost import KEPT_LENGTH_COST
from rocsafe_mapping.drawing.sheet import Shares

# What belongs together: places that cost more than this, without links thinner than so many
# pixels. Coarse things first, then what of them stands highest by itself.
ROUNDS = ((2.5, 3), (2.5, 9), (6.0, 5), (6.0, 13), (12.0, 7), (24.0, 9))
MARGIN_PX = 3
# What a pixel is worth that a better photograph shows.
SCORE_WORTH = 0.02
LEAST_SCORE = 0.05
# A thing that stays cut for more than this share of the cost is left alone.
WHOLE_SHARE = 0.6
AROUND = np.ones((3, 3), np.uint8)
Mask = NDArray[np.bool_]
Place = tuple[slice, slice]


class Shown(Protocol):
    """What a photograph can show."""

    @property
    def window(self) -> Window:
        """Where."""

    @property
    def scores(self) -> Shares:
        """How well it shows each pixel, 0 where it does not, shape (height, width)."""


def keep_whole(labels: Labels, cost: Shares, views: Sequence[Shown], window: Window) -> None:
    """Give things that seams cut to one photograph each, in `labels`, where that costs less.

    Parameters
    ----------
    labels: index in `views` of who is shown at each pixel of `window`, changed here.
    cost: of a seam through each pixel.
    """
    # A seam must keep off what stands up by a pixel.
    cost = cv2.dilate(cost, AROUND)
    for least, width in ROUNDS:
        for place, is_thing in _things(labels, cost > least, width):
            row, column = window.row + place[0].start, window.column + place[1].start
            box = Window(row, column, *is_thing.shape)
            # How far others disagree with what is about the thing is not known.
            near = set(np.unique(labels[place]).tolist()) - {NOBODY}
            scores = {number: _scores(views[number], box) for number in sorted(near)}
            labels[place] = _best(labels[place], cost[place], is_thing, scores)


def _things(labels: Labels, stands: Mask, width: int) -> list[tuple[Place, Mask]]:
    """Return the things that are shown by more than one photograph, each with its place."""
    opened = cv2.morphologyEx(
        stands.astype(np.uint8), cv2.MORPH_OPEN, np.ones((width, width), np.uint8)
    )
    count, numbers, boxes, _ = cv2.connectedComponentsWithStats(cv2.dilate(opened, AROUND))
    found = []
    for number in range(1, count):
        column, row, box_width, box_height = boxes[number, :4].tolist()
        place = (
            slice(max(row - MARGIN_PX, 0), row + box_height + MARGIN_PX),
            slice(max(column - MARGIN_PX, 0), column + box_width + MARGIN_PX),
        )
        is_thing = numbers[place] == number
        about = cv2.dilate(is_thing.astype(np.uint8), AROUND, iterations=2) > 0
        if np.ptp(labels[place][about]) > 0:
            found.append((place, is_thing))
    return found


def _scores(view: Shown, box: Window) -> Shares:
    """Return how well a photograph shows each pixel of `box`."""
    found = np.zeros((box.height, box.width), np.float32)
    shared = view.window.cut(box)
    found[shared.within(box)] = view.scores[shared.within(view.window)]
    return found


def _best(labels: Labels, cost: Shares, is_thing: Mask, scores: dict[int, Shares]) -> Labels:
    """Return the labels of a place, those of the thing changed if that makes seams cheaper."""
    best, least = labels, WHOLE_SHARE * _seams_cost(labels, cost)
    for number, score in scores.items():
        taken = is_thing & (score > LEAST_SCORE)
        changed = np.where(taken, np.int32(number), labels)
        total = _seams_cost(changed, cost) - SCORE_WORTH * float(score[taken].sum())
        if total < least:
            best, least = changed, total
    return best


def _seams_cost(labels: Labels, cost: Shares) -> float:
    """Return what all seams between neighbouring pixels cost."""
    total = 0.0
    for lines, prices in ((labels, cost), (labels.T, cost.T)):
        is_seam = lines[1:] != lines[:-1]
        total += float(np.sum((prices[1:] + prices[:-1])[is_seam]))
        total += 2.0 * KEPT_LENGTH_COST * int(is_seam.sum())
    return total
