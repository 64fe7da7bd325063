# SPDX-License-Identifier: Apache-2.0
"""Heights of objects above the ground, where two photographs show them.

A flat map shows a roof displaced outwards, by its height. Where a second photograph shows the
roof, its height is measured by a plane sweep. Where only one photograph shows a place, or the two
do not correlate, the height is unknown: there an expected height is used, from the known heights
nearby and, with little weight, of the whole map.
"""

import os
from collections.abc import Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import cv2
import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.drawing.coarse_view import CoarseView, Labels
from rocsafe_mapping.drawing.grid import MapGrid, Window
from rocsafe_mapping.drawing.placed_photo import PlacedPhoto, Shares
from rocsafe_mapping.drawing.plane_sweep import NOT_SEEN, SweepImage, likeness
from rocsafe_mapping.drawing_options import ReliefOptions

# Each has the pictures of a photograph for all heights that are tried.
MOST_THREADS = 4
# Where a photograph is shown and its own pixels; their heights, and which of them are seen twice.
Measured = tuple[tuple[slice, slice], BoolArray, Shares, BoolArray]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Relief:
    """Heights above the ground, on the coarse grid.

    Attributes
    ----------
    heights_m
        Of what is shown above the ground, NaN where unknown, (height, width).
    rise_m
        Root mean square of the expected height, (height, width).
    """

    heights_m: Shares
    rise_m: Shares


def relief(
    views: Mapping[str, CoarseView],
    placed_photos: Mapping[str, PlacedPhoto],
    tied: Collection[str],
    labels: tuple[Labels, Window],
    grid: MapGrid,
    options: ReliefOptions,
) -> Relief:
    """Return the heights of what stands on the ground.

    Parameters
    ----------
    views, placed_photos
        By name of photograph.
    tied
        Photographs placed well enough to measure heights.
    labels
        Index of who is shown, in the sorted names of `views`, and where that is.
    grid
        The coarse grid.
    """
    owner, window = labels
    heights = np.full(owner.shape, np.nan, np.float32)
    is_twice = np.zeros(owner.shape, bool)
    looks = {
        name: _sweep_image(views[name], placed_photos[name], grid, options.edge_px)
        for name in sorted(tied)
    }

    def measured(number: int, name: str) -> Measured | None:
        part = views[name].window.cut(window)
        is_own = owner[part.within(window)] == number
        if name not in looks or not is_own.any():
            return None
        box, is_own = _grown_about(is_own, part, options.compared_px)
        partners = _partners(looks[name], looks, box, is_own, options)
        if not partners:
            return None
        found, is_seen = _heights(looks[name], partners, box, options)
        return box.within(window), is_own, found[is_own], is_seen[is_own]

    # The work is done by OpenCV and numpy, which let threads run beside each other.
    names = sorted(views)
    with ThreadPoolExecutor(min(os.cpu_count() or 1, MOST_THREADS)) as threads:
        for one in filter(None, threads.map(measured, range(len(names)), names)):
            place, is_own, found, is_seen = one
            heights[place][is_own] = found
            is_twice[place][is_own] = is_seen
    return Relief(heights_m=heights, rise_m=_rise(heights, is_twice, options))


def _sweep_image(view: CoarseView, placed: PlacedPhoto, grid: MapGrid, edge_px: int) -> SweepImage:
    ground_m = float(np.median(placed.surface.at(placed.corners_m)))
    is_seen = (view.scores > 0.0).astype(np.uint8)
    window = np.ones((edge_px, edge_px), np.uint8)
    return SweepImage(
        window=view.window,
        gray=np.asarray(cv2.cvtColor(view.colours, cv2.COLOR_BGR2GRAY), np.uint8),
        is_seen=cv2.erode(is_seen, window, borderType=cv2.BORDER_CONSTANT, borderValue=0),
        below=grid.places_of(placed.pose.centre[np.newaxis, :2])[0],
        height_m=float(placed.pose.centre[2]) - ground_m,
    )


def _grown_about(is_own: BoolArray, part: Window, margin_px: int) -> tuple[Window, BoolArray]:
    """Return the window about the own pixels, with a margin for correlations, and its mask."""
    slices = []
    for axis in (1, 0):
        lines = np.flatnonzero(is_own.any(axis=axis))
        low = max(int(lines[0]) - margin_px, 0)
        slices.append(slice(low, min(int(lines[-1]) + 1 + margin_px, is_own.shape[1 - axis])))
    return part.part(slices[0], slices[1]), is_own[slices[0], slices[1]]


def _partners(
    first: SweepImage,
    looks: Mapping[str, SweepImage],
    box: Window,
    is_own: BoolArray,
    options: ReliefOptions,
) -> list[SweepImage]:
    """Return the nearest photographs that show the own pixels from elsewhere."""
    near = []
    for other in looks.values():
        away_px = float(np.linalg.norm(other.below - first.below))
        if other is not first and not box.cut(other.window).is_empty:
            near.append((away_px, other))
    chosen: list[SweepImage] = []
    seen = np.zeros(is_own.shape, np.uint8)
    for _, other in sorted(near, key=lambda found: found[0]):
        shared = box.cut(other.window)
        shows = np.zeros(is_own.shape, bool)
        shows[shared.within(box)] = other.is_seen[shared.within(other.window)] > 0
        new = np.count_nonzero(shows & is_own & (seen < options.enough))
        if (
            new > options.new_share * np.count_nonzero(is_own)
            and len(chosen) < options.most_partners
        ):
            chosen.append(other)
            seen += shows
    return chosen


def _heights(
    first: SweepImage, others: Sequence[SweepImage], box: Window, options: ReliefOptions
) -> tuple[Shares, BoolArray]:
    """Return the heights in `box`, NaN where unknown, and what two photographs show."""
    heights_m, level = _tried(first, others, options)
    alike = likeness(first, box, others, heights_m, options)
    is_twice: BoolArray = alike[level] > NOT_SEEN
    is_twice &= first.is_seen[box.within(first.window)] > 0
    ground = alike[level - 1 : level + 2].max(axis=0)
    alike -= (options.height_penalty / first.height_m * np.abs(heights_m))[
        :, np.newaxis, np.newaxis
    ]
    best = alike.argmax(axis=0)
    most = np.take_along_axis(alike, best[np.newaxis], 0)[0]
    stands = is_twice & (most > options.alike) & (most - ground > options.more_alike)
    stands = _without_spots(stands, options.least_spot_px)
    found = np.where(stands, heights_m[best], np.where(ground > options.alike, 0.0, np.nan))
    return np.where(is_twice, found, np.nan).astype(np.float32), is_twice


def _tried(
    first: SweepImage, others: Sequence[SweepImage], options: ReliefOptions
) -> tuple[FloatArray, int]:
    """Return the heights that are tried, and which of them is the ground's."""
    longest_px = max(float(np.linalg.norm(other.below - first.below)) for other in others)
    # Two photographs show a point that stands z high z / (h - z) baselines apart.
    step = options.step_px / longest_px
    low = max(int(-options.lowest_share / (1.0 - options.lowest_share) / step), 1)
    high = max(int(options.highest_share / (1.0 - options.highest_share) / step), 1)
    ratios = step * np.arange(-low, high + 1)
    return first.height_m * ratios / (1.0 + ratios), low


def _without_spots(stands: BoolArray, least_px: int) -> BoolArray:
    _, numbers, figures, _ = cv2.connectedComponentsWithStats(stands.astype(np.uint8))
    is_large = figures[:, cv2.CC_STAT_AREA] >= least_px
    is_large[0] = False
    kept: BoolArray = is_large[numbers]
    return kept


def _rise(heights: Shares, is_twice: BoolArray, options: ReliefOptions) -> Shares:
    """Return the expected height at each pixel, root mean square."""
    rise = np.zeros(heights.shape, np.float32)
    told = heights[np.isfinite(heights)]
    standing = told[told != 0.0]
    if not len(standing):
        return rise
    squares = float(np.sum(np.square(standing)))
    unlike = options.unlike_stands * squares / len(standing)
    twice = int(np.count_nonzero(is_twice))
    usual = (squares + unlike * (twice - len(told))) / twice
    # In bands of rows, to limit memory.
    for top in range(0, len(heights), options.band_rows):
        start = max(top - 2 * options.nearby_px, 0)
        rows = slice(start, top + options.band_rows + 2 * options.nearby_px)
        found = _rise_of(
            heights[rows], np.where(is_twice[rows], np.float32(unlike), usual), options
        )
        rise[top : top + options.band_rows] = found[top - start : top - start + options.band_rows]
    return rise


def _rise_of(heights: Shares, expected: FloatArray, options: ReliefOptions) -> Shares:
    """Return the same of a part; `expected` is the square where no height nearby is known."""
    is_told = np.isfinite(heights)
    told = is_told.astype(np.float32)
    square = np.where(is_told, heights, np.float32(0.0)) ** 2
    side = (options.nearby_px, options.nearby_px)
    near, known = (cv2.blur(cv2.blur(part, side), side) for part in (square, told))
    guess = (near + options.usual_weight * expected) / (known + options.usual_weight)
    side = (options.smoothed_px, options.smoothed_px)
    known = np.maximum(cv2.blur(told, side), np.float32(1e-6))
    rise: Shares = np.sqrt(np.where(is_told, cv2.blur(square, side) / known, guess))
    return rise.astype(np.float32)
