# SPDX-License-Identifier: Apache-2.0
"""Factors that make the brightness and colour of photographs alike."""

from collections.abc import Mapping

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix, diags
from scipy.sparse.linalg import spsolve

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.drawing.coarse_view import CoarseView, overlapping
from rocsafe_mapping.drawing_options import GainOptions


def gains(
    views: Mapping[str, CoarseView], options: GainOptions
) -> dict[str, tuple[float, float, float]]:
    """Return factors of blue, green, red for each photograph, by least squares of logarithms."""
    names = sorted(views)
    first, second, ratios, counts = [], [], [], []
    for a, b in overlapping([views[name].window for name in names]):
        ratio = _log_ratio(views[names[a]], views[names[b]], options)
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
    # The gains correct the ratio of brightness, second over first.
    wanted = np.array(ratios)
    light = wanted.mean(axis=1, keepdims=True)
    common = _held(design, weight, light, options.brightness_hold)
    logs = common + _held(design, weight, wanted - light, options.colour_hold)
    logs = np.clip(logs, -options.largest_log, options.largest_log)
    return {name: tuple(np.exp(log).tolist()) for name, log in zip(names, logs, strict=True)}


def _held(design: csr_matrix, weight: FloatArray, wanted: FloatArray, hold: float) -> FloatArray:
    """Return the values (n, k) whose differences are `wanted` but for being held to 0."""
    normal = design.T @ diags(weight) @ design
    normal = (normal + hold * diags(normal.diagonal() + 1.0)).tocsc()
    solved = spsolve(normal, design.T @ (weight[:, np.newaxis] * wanted))
    return np.asarray(solved).reshape(design.shape[1], -1)


def _log_ratio(
    first: CoarseView, second: CoarseView, options: GainOptions
) -> tuple[FloatArray, float] | None:
    """Return log(second / first) of the common colours, and its weight."""
    shared = first.window.cut(second.window)
    if shared.is_empty:
        return None
    at_first, at_second = shared.within(first.window), shared.within(second.window)
    one, other = first.colours[at_first], second.colours[at_second]
    usable = (first.scores[at_first] > 0.0) & (second.scores[at_second] > 0.0)
    for colours in (one, other):
        usable &= np.all((colours > options.dark) & (colours < options.bright), axis=2)
    count = int(usable.sum())
    if count < options.least_common_px:
        return None
    ratio = np.log(other[usable].astype(np.float32)) - np.log(one[usable].astype(np.float32))
    return np.median(ratio, axis=0).astype(np.float64), float(np.sqrt(count))
