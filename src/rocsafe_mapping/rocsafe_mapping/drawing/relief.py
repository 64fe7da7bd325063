# SPDX-License-Identifier: Apache-2.0
"""How high what the map shows stands above the ground, where two photographs tell.

A flat map shows a roof where the photograph saw it, leaning outwards. Where a second photograph
shows the roof too, both tell how high it is, and so how far it leans. Where only one photograph
sees the ground, or the two show nothing alike, nothing tells: there things are reckoned with as
they stand elsewhere on the map, and above all nearby.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.drawing.grid import MapGrid, Window
from rocsafe_mapping.drawing.labels import Labels
from rocsafe_mapping.drawing.plane_sweep import COMPARED_PX, NOT_SEEN, Look, likeness
from rocsafe_mapping.drawing.seams import CoarseView
from rocsafe_mapping.drawing.sheet import Shares, Sheet

# Heights that are tried, over the flying height, and the shift between them, coarse pixels.
LOWEST_SHARE, HIGHEST_SHARE = -0.04, 0.31
STEP_PX = 1.5
# Who is compared: not too near each other, and enough of them that most is seen twice more.
LEAST_BASELINE_SHARE, MOST_PARTNERS = 0.1, 3
ENOUGH, NEW_SHARE = 2, 0.05
# What is alike; and by how much a height must be more alike than the ground to be believed.
ALIKE, MORE_ALIKE = 0.5, 0.12
# A height as large as the flying height counts as so much less alike.
HEIGHT_PENALTY = 0.3
# Smaller spots of height, in coarse pixels, are chance.
LEAST_SPOT_PX = 8
# The window of a correlation that meets a thing tells its height: the mean over as much is taken.
SMOOTHED_PX = 5
# So far, in coarse pixels, what stands near tells what may stand where nothing tells; and what
# the whole map counts beside a neighbourhood that is all known.
NEARBY_PX, USUAL_WEIGHT = 15, 0.1
# Of places where two photographs show nothing alike so many stand up: where truth was known.
UNLIKE_STANDS = 0.45
# The outermost pixel of a photograph does not count: its window hangs over the edge by half.
EDGE_PX = 3
BAND_ROWS = 256


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Relief:
    """What stands on the ground, on the coarse grid.

    Attributes
    ----------
    heights_m: of what is shown above the ground, NaN where nothing tells, (height, width).
    rise_m: root mean square height that is to be reckoned with, (height, width).
    """

    heights_m: Shares
    rise_m: Shares


def relief(
    views: Mapping[str, CoarseView],
    sheets: Mapping[str, Sheet],
    tied: Collection[str],
    labels: tuple[Labels, Window],
    grid: MapGrid,
) -> Relief:
    """Return what stands on the ground.

    Parameters
    ----------
    views, sheets: by name of photograph.
    tied: photographs whose places are good enough to tell heights.
    labels: index of who is shown, in the sorted names of `views`, and where that is.
    grid: the coarse grid.
    """
    owner, window = labels
    heights = np.full(owner.shape, np.nan, np.float32)
    is_twice = np.zeros(owner.shape, bool)
    looks = {name: _look(views[name], sheets[name], grid) for name in sorted(tied)}
    for number, name in enumerate(sorted(views)):
        part = views[name].window.cut(window)
        is_own = owner[part.within(window)] == number
        if name not in looks or not is_own.any():
            continue
        box, is_own = _grown_about(is_own, part)
        partners = _partners(looks[name], looks, box, is_own)
        if partners:
            found, is_seen = _heights(looks[name], partners, box)
            place = box.within(window)
            heights[place][is_own] = found[is_own]
            is_twice[place][is_own] = is_seen[is_own]
    return Relief(heights_m=heights, rise_m=_rise(heights, is_twice))


def _look(view: CoarseView, sheet: Sheet, grid: MapGrid) -> Look:
    ground_m = float(np.median(sheet.surface.at(sheet.corners_m)))
    is_seen = (view.scores > 0.0).astype(np.uint8)
    window = np.ones((EDGE_PX, EDGE_PX), np.uint8)
    return Look(
        window=view.window,
        gray=np.asarray(cv2.cvtColor(view.colours, cv2.COLOR_BGR2GRAY), np.uint8),
        is_seen=cv2.erode(is_seen, window, borderType=cv2.BORDER_CONSTANT, borderValue=0),
        below=grid.places_of(sheet.pose.centre[np.newaxis, :2])[0],
        height_m=float(sheet.pose.centre[2]) - ground_m,
    )


def _grown_about(is_own: BoolArray, part: Window) -> tuple[Window, BoolArray]:
    """Return the window about what is own, room for correlations about it, and what is own."""
    slices = []
    for axis in (1, 0):
        lines = np.flatnonzero(is_own.any(axis=axis))
        low = max(int(lines[0]) - COMPARED_PX, 0)
        slices.append(slice(low, min(int(lines[-1]) + 1 + COMPARED_PX, is_own.shape[1 - axis])))
    return part.part(slices[0], slices[1]), is_own[slices[0], slices[1]]


def _partners(
    first: Look, looks: Mapping[str, Look], box: Window, is_own: BoolArray
) -> list[Look]:
    """Return photographs that see what is own from elsewhere, the nearest first."""
    near = []
    for other in looks.values():
        away_px = float(np.linalg.norm(other.below - first.below))
        if other is not first and not box.cut(other.window).is_empty:
            near.append((away_px, other))
    chosen: list[Look] = []
    seen = np.zeros(is_own.shape, np.uint8)
    for _, other in sorted(near, key=lambda found: found[0]):
        shared = box.cut(other.window)
        shows = np.zeros(is_own.shape, bool)
        shows[shared.within(box)] = other.is_seen[shared.within(other.window)] > 0
        new = np.count_nonzero(shows & is_own & (seen < ENOUGH))
        if new > NEW_SHARE * np.count_nonzero(is_own) and len(chosen) < MOST_PARTNERS:
            chosen.append(other)
            seen += shows
    return chosen


def _heights(first: Look, others: Sequence[Look], box: Window) -> tuple[Shares, BoolArray]:
    """Return the heights of what `first` shows of `box`, NaN if unlike, and what is seen twice."""
    heights_m, level = _tried(first, others)
    alike = likeness(first, box, others, heights_m)
    is_twice: BoolArray = alike[level] > NOT_SEEN
    is_twice &= first.is_seen[box.within(first.window)] > 0
    ground = alike[level - 1 : level + 2].max(axis=0)
    alike -= (HEIGHT_PENALTY / first.height_m * np.abs(heights_m))[:, np.newaxis, np.newaxis]
    best = alike.argmax(axis=0)
    most = np.take_along_axis(alike, best[np.newaxis], 0)[0]
    stands = is_twice & (most > ALIKE) & (most - ground > MORE_ALIKE)
    stands = _without_spots(stands)
    found = np.where(stands, heights_m[best], np.where(ground > ALIKE, 0.0, np.nan))
    return np.where(is_twice, found, np.nan).astype(np.float32), is_twice


def _tried(first: Look, others: Sequence[Look]) -> tuple[FloatArray, int]:
    """Return the heights that are tried, and which of them is the ground's."""
    longest_px = max(float(np.linalg.norm(other.below - first.below)) for other in others)
    # Two photographs show a point that stands z high z / (h - z) baselines apart.
    step = STEP_PX / longest_px
    low = max(int(-LOWEST_SHARE / (1.0 - LOWEST_SHARE) / step), 1)
    high = max(int(HIGHEST_SHARE / (1.0 - HIGHEST_SHARE) / step), 1)
    ratios = step * np.arange(-low, high + 1)
    return first.height_m * ratios / (1.0 + ratios), low


def _without_spots(stands: BoolArray) -> BoolArray:
    _, numbers, figures, _ = cv2.connectedComponentsWithStats(stands.astype(np.uint8))
    is_large = figures[:, cv2.CC_STAT_AREA] >= LEAST_SPOT_PX
    is_large[0] = False
    kept: BoolArray = is_large[numbers]
    return kept


def _rise(heights: Shares, is_twice: BoolArray) -> Shares:
    """Return the height that is to be reckoned with at each pixel."""
    rise = np.zeros(heights.shape, np.float32)
    told = heights[np.isfinite(heights)]
    standing = told[told != 0.0]
    if not len(standing):
        return rise
    squares = float(np.sum(np.square(standing)))
    unlike = UNLIKE_STANDS * squares / len(standing)
    twice = int(np.count_nonzero(is_twice))
    usual = (squares + unlike * (twice - len(told))) / twice
    # In bands of rows: memory is not that of the whole map many times over.
    for top in range(0, len(heights), BAND_ROWS):
        start = max(top - 2 * NEARBY_PX, 0)
        rows = slice(start, top + BAND_ROWS + 2 * NEARBY_PX)
        found = _rise_of(heights[rows], np.where(is_twice[rows], np.float32(unlike), usual))
        rise[top : top + BAND_ROWS] = found[top - start : top - start + BAND_ROWS]
    return rise


def _rise_of(heights: Shares, expected: FloatArray) -> Shares:
    """Return the same of a part; `expected` is the square where nothing near tells."""
    is_told = np.isfinite(heights)
    told = is_told.astype(np.float32)
    square = np.where(is_told, heights, np.float32(0.0)) ** 2
    side = (NEARBY_PX, NEARBY_PX)
    near, known = (cv2.blur(cv2.blur(part, side), side) for part in (square, told))
    guess = (near + USUAL_WEIGHT * expected) / (known + USUAL_WEIGHT)
    side = (SMOOTHED_PX, SMOOTHED_PX)
    known = np.maximum(cv2.blur(told, side), np.float32(1e-6))
    rise: Shares = np.sqrt(np.where(is_told, cv2.blur(square, side) / known, guess))
    return rise.astype(np.float32)
