# SPDX-License-Identifier: Apache-2.0
"""Random irregular outlines, and smooth lines."""

from collections.abc import Sequence

import numpy as np

from rocsafe_scene.painting.marks import (
    Coordinates,
    Paint,
    Points,
    Shape,
)


def generator(seed: int, *parts: int) -> np.random.Generator:
    """Return the generator of a seed and further numbers."""
    return np.random.default_rng([seed, *parts])


def smooth_line(points: Coordinates, spacing_m: float = 2.0) -> Points:
    """Return a Catmull-Rom curve through points (n, 2), sampled every `spacing_m` or so."""
    through = np.asarray(points, float)
    padded = np.vstack([2 * through[0] - through[1], through, 2 * through[-1] - through[-2]])
    pieces = [_piece(padded[i : i + 4], spacing_m) for i in range(len(through) - 1)]
    return np.vstack([*pieces, through[-1:]])


def blob(
    rng: np.random.Generator,
    centre: Sequence[float] | Points,
    radii_m: tuple[float, float],
    yaw_rad: float = 0.0,
) -> Points:
    """Return an irregular rounded outline, with half axes `radii_m`."""
    angles = np.linspace(0.0, 2.0 * np.pi, 28, endpoint=False)
    wobble = np.ones_like(angles)
    for wave in (2, 3, 5, 7):
        size, phase = rng.uniform(0.0, 0.32 / wave**0.8), rng.uniform(0.0, 2.0 * np.pi)
        wobble += size * np.sin(wave * angles + phase)
    local = np.column_stack([radii_m[0] * np.cos(angles), radii_m[1] * np.sin(angles)])
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    turned = local * wobble[:, None] @ np.array([[cos, sin], [-sin, cos]])
    return turned + np.asarray(centre, float)


def faded(outline: Points, paint: Paint, rings: int = 9, spread: float = 0.45) -> Shape:
    """Return a patch that fades out: nested outlines, from `1 + spread` to `1 - spread` of it."""
    centre = outline.mean(axis=0)
    scales = np.linspace(1.0 + spread, 1.0 - spread, rings)
    return Shape(
        tuple(centre + (outline - centre) * scale for scale in scales), paint, is_faded=True
    )


def _piece(corners: Points, spacing_m: float) -> Points:
    p0, p1, p2, p3 = corners
    count = max(2, int(np.linalg.norm(p2 - p1) / spacing_m))
    t = np.linspace(0.0, 1.0, count, endpoint=False)[:, None]
    curve: Points = 0.5 * (
        2.0 * p1
        + (p2 - p0) * t
        + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * t**2
        + (3.0 * p1 - p0 - 3.0 * p2 + p3) * t**3
    )
    return curve
