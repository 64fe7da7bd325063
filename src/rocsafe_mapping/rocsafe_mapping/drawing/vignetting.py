# SPDX-License-Identifier: Apache-2.0
"""Fall-off of a lens's brightness towards the corners, found where photographs overlap.

The same ground is seen at different distances from the middle of the image: the logarithm of the
ratio of brightness gives the fall-off, an even polynomial (Goldman: Vignette and exposure
calibration and compensation, 2010), whatever the ground looks like.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.drawing.coarse_view import CoarseView, overlapping
from rocsafe_mapping.drawing.placed_photo import Shares
from rocsafe_mapping.drawing_options import GainOptions, VignettingOptions


@dataclass(frozen=True, slots=True)
class FallOff:
    """Logarithm of the brightness: `square` r^2 + `fourth` r^4, r = 1 in the corners."""

    square: float
    fourth: float

    def logs(self, squares: Shares) -> Shares:
        """Return the logarithms of brightness at r^2."""
        found: Shares = squares * np.float32(self.square) + squares**2 * np.float32(self.fourth)
        return found

    def undone(self, picture: NDArray[np.uint8], squares: Shares) -> NDArray[np.uint8]:
        """Return a picture, whose pixels lie at r^2 = `squares`, as bright as in the middle."""
        factors = np.exp(-self.logs(np.clip(squares, 0.0, 1.0)))
        bright = cv2.multiply(picture, cv2.merge([factors] * 3), dtype=cv2.CV_8U)
        return np.asarray(bright, np.uint8)


def fall_offs(
    views: Mapping[str, CoarseView],
    lenses: Mapping[str, str],
    gains: GainOptions,
    options: VignettingOptions,
) -> dict[str, FallOff]:
    """Return the fall-off of each lens that clearly has one; `lenses` are by photograph."""
    names = sorted(views)
    sums: dict[str, tuple[FloatArray, FloatArray, int]] = {}
    for a, b in overlapping([views[name].window for name in names]):
        lens = lenses[names[a]]
        if lens != lenses[names[b]]:
            continue
        compared = _compared(views[names[a]], views[names[b]], gains, options)
        if compared is not None:
            design, ratio = compared
            normal, right, count = sums.get(lens, (np.zeros((2, 2)), np.zeros(2), 0))
            sums[lens] = normal + design.T @ design, right + design.T @ ratio, count + 1
    found = {}
    for lens, (normal, right, count) in sums.items():
        square, fourth = np.linalg.lstsq(normal, right, rcond=1e-4)[0].tolist()
        fall_off = FallOff(square, fourth)
        logs = fall_off.logs(np.linspace(0.0, 1.0, 11, dtype=np.float32))
        is_real = options.largest_log < logs[-1] < -options.least_log and np.all(np.diff(logs) < 0)
        if count >= options.least_pairs and is_real:
            found[lens] = fall_off
    return found


def _compared(
    first: CoarseView, second: CoarseView, gains: GainOptions, options: VignettingOptions
) -> tuple[FloatArray, FloatArray] | None:
    """Return the differences of r^2 and r^4 and the log ratios of brightness, without means."""
    shared = first.window.cut(second.window)
    if shared.is_empty:
        return None
    at_first, at_second = shared.within(first.window), shared.within(second.window)
    one, other = (
        view.colours[at].astype(np.float32).mean(axis=2)
        for view, at in ((first, at_first), (second, at_second))
    )
    usable = (first.scores[at_first] > 0.0) & (second.scores[at_second] > 0.0)
    for light in (one, other):
        usable &= (light > gains.dark) & (light < gains.bright)
    if int(usable.sum()) < options.least_common_px:
        return None
    ratio = (np.log(other[usable]) - np.log(one[usable])).astype(float)
    near, far = first.squares[at_first][usable], second.squares[at_second][usable]
    design = np.column_stack([far - near, far**2 - near**2]).astype(float)
    ratio -= np.median(ratio)
    kept = np.abs(ratio) < options.largest_ratio
    design, ratio = design[kept], ratio[kept]
    if not len(ratio):
        return None
    return design - design.mean(axis=0), ratio - ratio.mean()
