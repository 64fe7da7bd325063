# SPDX-License-Identifier: Apache-2.0
"""Paint of fields, meadows and yards."""

import math

import numpy as np

from rocsafe_scene.painting.marks import (
    Colour,
    Coordinates,
    Mark,
    Paint,
    Points,
    Shape,
    polygon,
    ribbon,
)
from rocsafe_scene.painting.outlines import blob, faded, generator

_SOIL = Paint((122, 94, 66), 175, 0.93)
_FURROW = Paint((88, 65, 45), 170, 0.55)
_RIDGE = Paint((150, 120, 88), 190, 0.45)


def ploughed_field(outline: Coordinates, yaw_rad: float, seed: int) -> tuple[Mark, ...]:
    """Return a ploughed field, its furrows in direction `yaw_rad`."""
    corners = np.asarray(outline, float)
    rng = generator(seed, 31, 5)
    ground: list[Mark] = [polygon(corners, _SOIL)]
    for patch in range(10):
        place = _within(corners, rng)
        soil = Paint((96, 72, 50) if patch % 2 else (146, 118, 88), 175, 0.35)
        ground.append(faded(blob(rng, place, (9.0, 5.0), yaw_rad), soil))
    furrows: list[Points] = []
    ridges: list[Points] = []
    for offset, line in _rows(corners, yaw_rad, 0.62):
        wobble = 0.05 * np.sin(line[:, :1] * 0.31 + offset) + rng.normal(0.0, 0.015, line.shape)
        furrows.append(ribbon(line + wobble, 0.22))
        ridges.append(ribbon(line + wobble + 0.2, 0.14))
    ground += _grouped(furrows, 40, _FURROW) + _grouped(ridges, 40, _RIDGE)
    return tuple(ground)


def meadow(
    outline: Coordinates,
    yaw_rad: float,
    colour: Colour,
    seed: int,
    swath_m: float = 3.2,
) -> tuple[Mark, ...]:
    """Return a meadow in its own green, with the swaths of the last mowing."""
    corners = np.asarray(outline, float)
    rng = generator(seed, 32, 6)
    ground: list[Mark] = [polygon(corners, Paint(colour, 110, 0.5))]
    swaths = [ribbon(line, 0.96 * swath_m) for _, line in _rows(corners, yaw_rad, swath_m)]
    for first, colour_of in enumerate(((150, 160, 88), (62, 84, 40))):
        for opacity, start in ((0.15, first), (0.22, first + 2)):
            ground += _grouped(swaths[start::4], 6, Paint(colour_of, 110, opacity))
    for _ in range(8):
        place = _within(corners, rng)
        ground.append(
            faded(
                blob(rng, place, (6.0, 3.0), rng.uniform(0.0, 3.0)),
                Paint((140, 140, 78), 140, 0.3),
            )
        )
    return tuple(ground)


def yard(outline: Coordinates, colour: Colour) -> tuple[Mark, ...]:
    """Return a paved or gravelled yard."""
    corners = np.asarray(outline, float)
    return (polygon(corners, Paint(colour, 120, 0.92, 0.3)),)


def _grouped(outlines: list[Points], size: int, paint: Paint) -> list[Mark]:
    """Return polygons in shapes of `size` each, which are faster to paint than single ones."""
    groups = [tuple(outlines[at : at + size]) for at in range(0, len(outlines), size)]
    return [Shape(group, paint) for group in groups]


def _rows(corners: Points, yaw_rad: float, spacing_m: float) -> list[tuple[float, Points]]:
    """Return (offset, line) of parallel rows within a convex outline."""
    along = np.array([math.cos(yaw_rad), math.sin(yaw_rad)])
    across = np.array([-along[1], along[0]])
    s, t = corners @ along, corners @ across
    rows = []
    for offset in np.arange(t.min() + 0.5 * spacing_m, t.max(), spacing_m).tolist():
        ends = _crossings(s, t, float(offset))
        if len(ends) == 2 and ends[1] - ends[0] > 2.0:
            steps = np.linspace(ends[0] + 0.4, ends[1] - 0.4, max(2, int(np.ptp(ends) / 4.0)))
            rows.append((float(offset), np.outer(steps, along) + offset * across))
    return rows


def _crossings(s: Points, t: Points, offset: float) -> list[float]:
    """Return where an outline in (s, t) is cut by the line t = offset, in order."""
    cuts = []
    for a, b in zip(range(len(s)), [*range(1, len(s)), 0], strict=True):
        if (t[a] - offset) * (t[b] - offset) < 0.0:
            cuts.append(float(s[a] + (offset - t[a]) / (t[b] - t[a]) * (s[b] - s[a])))
    return sorted(cuts)


def _within(corners: Points, rng: np.random.Generator) -> Points:
    """Return a point inside a convex outline."""
    weights = rng.dirichlet(np.ones(len(corners)))
    place: Points = weights @ corners
    return place
