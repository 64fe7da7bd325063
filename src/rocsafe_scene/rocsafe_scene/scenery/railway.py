# SPDX-License-Identifier: Apache-2.0
"""A single railway track: ballast, sleepers, rails. The gauge is Ireland's, 1600 mm."""

import numpy as np

from rocsafe_scene.scenery.marks import (
    Mark,
    Paint,
    Placing,
    Points,
    normals_of,
    rectangle,
    stroke,
)
from rocsafe_scene.scenery.outlines import faded, generator
from rocsafe_scene.scenery.scene import Thing

GAUGE_M = 1.6
SLEEPER_SPACING_M = 0.65
_RAIL_WIDTH_M = 0.13

_SHOULDER = Paint((110, 103, 88), 200)
_BALLAST = Paint((139, 132, 122), 235)
_CROWN = Paint((150, 144, 135), 245)
_CESS = Paint((104, 98, 78), 150, 0.6)
_SLEEPER = Paint((168, 164, 156), 60)
_OLD_SLEEPER = Paint((92, 78, 66), 90)
_RAIL_SIDE = Paint((74, 52, 40), 20)
_RAIL_TOP = Paint((186, 184, 182), 10)
_SCATTER = Paint((136, 128, 116), 230, 0.7)


def track(name: str, line: Points, gaps: tuple[tuple[float, float], ...], seed: int) -> Thing:
    """Return a track along `line` (n, 2); in the `gaps`, metres along it, it has no rails."""
    along = _distances(line)
    ground: list[Mark] = [
        stroke(line, 7.6, _CESS),
        stroke(line, 5.6, _SHOULDER),
        stroke(line, 4.6, _BALLAST),
        stroke(line, 3.0, _CROWN),
    ]
    ground += _sleepers(line, along, gaps, generator(seed, 11))
    for start, end in _kept(gaps, float(along[-1])):
        kept = _between(line, along, start, end)
        for side in (-1.0, 1.0):
            rail = kept + side * 0.5 * GAUGE_M * normals_of(kept)
            ground += [stroke(rail, _RAIL_WIDTH_M + 0.08, _RAIL_SIDE)]
            ground += [stroke(rail, _RAIL_WIDTH_M - 0.04, _RAIL_TOP)]
    middle = line[len(line) // 2]
    return Thing(
        name=name,
        kind='railway',
        placing=Placing(float(middle[0]), float(middle[1])),
        size_m=(float(along[-1]), GAUGE_M, 0.0),
        ground=tuple(ground),
    )


def _sleepers(
    line: Points, along: Points, gaps: tuple[tuple[float, float], ...], rng: np.random.Generator
) -> list[Mark]:
    marks: list[Mark] = []
    for distance in np.arange(0.3, along[-1], SLEEPER_SPACING_M).tolist():
        placing = _placing(line, along, float(distance))
        paint = _OLD_SLEEPER if rng.uniform() < 0.12 else _SLEEPER.lit(rng.uniform(0.88, 1.08))
        is_torn = any(start < distance < end for start, end in gaps)
        if is_torn and rng.uniform() < 0.3:
            continue
        if is_torn:
            x, y, turn = rng.normal(0.0, (0.45, 0.45, 0.35)).tolist()
            placing = placing.moved(x, y, turn)
        marks.append(rectangle(placing, 0.26, 2.6, paint))
    return marks


def torn_rails(name: str, line: Points, gap: tuple[float, float], seed: int) -> Thing:
    """Return bent rails and scattered ballast of a torn stretch of track."""
    rng = generator(seed, 12)
    along = _distances(line)
    stretch = _between(line, along, *gap)
    swing = np.linspace(0.0, 1.0, len(stretch))
    marks: list[Mark] = []
    for _ in range(int((gap[1] - gap[0]) * 0.5)):
        place = stretch[int(rng.integers(len(stretch)))] + rng.normal(0.0, 2.6, 2)
        radii = rng.uniform(0.4, 1.5, 2)
        outline = place + _circle(rng, radii)
        marks.append(faded(outline, _SCATTER, spread=0.3))
    for side in (-1.0, 1.0):
        bend = rng.uniform(1.0, 2.6) * np.sin(np.pi * swing) * rng.choice([-1.0, 1.0])
        ripple = 0.5 * np.sin(rng.uniform(2.0, 3.5) * np.pi * swing + rng.uniform(0.0, 3.0))
        offset = side * 0.5 * GAUGE_M + bend + ripple * np.sin(np.pi * swing)
        rail = stretch + offset[:, None] * normals_of(stretch)
        marks += [stroke(rail, _RAIL_WIDTH_M + 0.08, _RAIL_SIDE)]
        marks += [stroke(rail, _RAIL_WIDTH_M - 0.05, _RAIL_TOP)]
    east, north = stretch[len(stretch) // 2].tolist()
    return Thing(
        name=name,
        kind='railway',
        placing=Placing(east, north),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(marks),
    )


def _circle(rng: np.random.Generator, radii: Points) -> Points:
    angles = np.sort(rng.uniform(0.0, 2.0 * np.pi, 12))
    return np.column_stack([radii[0] * np.cos(angles), radii[1] * np.sin(angles)])


def _kept(gaps: tuple[tuple[float, float], ...], length: float) -> list[tuple[float, float]]:
    edges = [0.0, *(edge for gap in gaps for edge in gap), length]
    return list(zip(edges[::2], edges[1::2], strict=True))


def _between(line: Points, along: Points, start: float, end: float) -> Points:
    count = max(3, int((end - start) / 1.0))
    at = np.linspace(start, end, count)
    return np.column_stack([np.interp(at, along, line[:, axis]) for axis in (0, 1)])


def _placing(line: Points, along: Points, distance: float) -> Placing:
    ends = _between(line, along, max(0.0, distance - 0.5), min(float(along[-1]), distance + 0.5))
    direction = ends[-1] - ends[0]
    east, north = ends[len(ends) // 2]
    return Placing(float(east), float(north), float(np.arctan2(direction[1], direction[0])))


def placing_on(line: Points, distance_m: float) -> Placing:
    """Return the placing of something that stands on the track."""
    return _placing(line, _distances(line), distance_m)


def _distances(line: Points) -> Points:
    """Return the distance of each point along `line`."""
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(lengths)])


def level_crossing(placing: Placing, length_m: float) -> tuple[Mark, ...]:
    """Return the panels on which a road crosses a track."""
    panel = Paint((96, 94, 92), 50)
    marks = [rectangle(placing, length_m, 4.4, panel)]
    for side in (-1.0, 1.0):
        groove = placing.moved(0.0, side * 0.5 * GAUGE_M)
        marks.append(rectangle(groove, length_m, 0.24, _RAIL_SIDE))
        marks.append(rectangle(groove, length_m, 0.1, _RAIL_TOP))
    return tuple(marks)
