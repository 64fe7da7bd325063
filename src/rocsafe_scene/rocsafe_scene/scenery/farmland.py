# SPDX-License-Identifier: Apache-2.0
"""Fields, houses, animals and tents."""

import math

import numpy as np

from rocsafe_scene.scenery.light import brightness, shadow_of, shadow_of_box, shadow_offset
from rocsafe_scene.scenery.marks import (
    Colour,
    Coordinates,
    Mark,
    Paint,
    Placing,
    Points,
    Shape,
    disc,
    polygon,
    rectangle,
    ribbon,
    stroke,
)
from rocsafe_scene.scenery.outlines import blob, faded, generator
from rocsafe_scene.scenery.rolling_stock import cylinder
from rocsafe_scene.scenery.scene import Thing

_SOIL = Paint((122, 94, 66), 175, 0.93)
_FURROW = Paint((88, 65, 45), 170, 0.55)
_RIDGE = Paint((150, 120, 88), 190, 0.45)
_SLATE = Paint((104, 106, 114), 60)
_TILE = Paint((150, 84, 62), 60)
_WALL = Paint((222, 216, 202), 20)


def ploughed_field(name: str, outline: Coordinates, yaw_rad: float, seed: int) -> Thing:
    """Return a ploughed field, its furrows in direction `yaw_rad`."""
    corners = np.asarray(outline, float)
    rng = generator(seed, 31, len(name))
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
    return _field(name, corners, ground)


def meadow(
    name: str,
    outline: Coordinates,
    yaw_rad: float,
    colour: Colour,
    seed: int,
    swath_m: float = 3.2,
) -> Thing:
    """Return a meadow in its own green, with the swaths of the last mowing."""
    corners = np.asarray(outline, float)
    rng = generator(seed, 32, len(name))
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
    return _field(name, corners, ground)


def house(
    name: str, placing: Placing, length_m: float, width_m: float, *, is_tiled: bool = False
) -> Thing:
    """Return a house with a gable roof, a chimney and courses of slates or tiles."""
    roof = _TILE if is_tiled else _SLATE
    x, y = 0.5 * length_m, 0.5 * width_m
    slope = math.radians(40.0)
    body: list[Mark] = [rectangle(placing, length_m - 0.5, width_m - 0.5, _WALL)]
    for side in (-1.0, 1.0):
        east = -math.sin(placing.yaw_rad) * side * math.sin(slope)
        north = math.cos(placing.yaw_rad) * side * math.sin(slope)
        light = brightness((east, north, math.cos(slope)))
        half = [[-x, 0.0], [x, 0.0], [x, side * y], [-x, side * y]]
        body.append(polygon(placing.to_world(half), roof.lit(0.9 * light)))
        for step in np.arange(0.3, y, 0.3).tolist():
            course = placing.to_world([[-x, side * step], [x, side * step]])
            body.append(stroke(course, 0.06, roof.lit(0.68 * light)))
    body.append(stroke(placing.to_world([[-x, 0.0], [x, 0.0]]), 0.22, roof.lit(1.25)))
    chimney = placing.moved(0.36 * length_m, 0.0)
    body += [
        rectangle(chimney, 0.7, 1.1, Paint((150, 120, 104), 40)),
        rectangle(chimney, 0.35, 0.7, Paint((40, 36, 34), 20)),
    ]
    eaves = placing.to_world([[-x, -y], [x, -y], [x, y], [-x, y]])
    ridge = placing.to_world([[-x, 0.0], [x, 0.0]]) + shadow_offset(3.2)
    shadow = (
        shadow_of(eaves, 3.6),
        shadow_of(np.vstack([eaves, ridge]), 3.6),
        shadow_of_box(chimney, 0.7, 1.1, 8.0),
    )
    return Thing(
        name=name,
        kind='house',
        placing=placing,
        size_m=(length_m, width_m, 7.0),
        colour=roof.colour,
        shadow=shadow,
        body=tuple(body),
    )


def yard(name: str, outline: Coordinates, colour: Colour = (172, 166, 154)) -> Thing:
    """Return a paved or gravelled yard."""
    corners = np.asarray(outline, float)
    return _field(name, corners, [polygon(corners, Paint(colour, 120, 0.92, 0.3))])


def tent(name: str, placing: Placing, colour: Colour) -> Thing:
    """Return an inflatable shelter, 8 m by 5.5 m, with its arches."""
    body: list[Mark] = list(cylinder(placing, 8.0, 2.75, Paint(colour, 20)))
    for x in np.linspace(-3.7, 3.7, 5).tolist():
        body.append(
            stroke(
                placing.to_world([[x, -2.7], [x, 0.0], [x, 2.7]]),
                0.42,
                Paint(colour, 15).lit(0.82),
            )
        )
        body.append(
            stroke(
                placing.to_world([[x - 0.1, -2.7], [x - 0.1, 0.0], [x - 0.1, 2.7]]),
                0.16,
                Paint(colour, 15).lit(1.2),
            )
        )
    return Thing(
        name=name,
        kind='tent',
        placing=placing,
        size_m=(8.0, 5.5, 3.0),
        colour=colour,
        shadow=(shadow_of_box(placing, 8.0, 4.4, 2.8),),
        body=tuple(body),
    )


def sheep(name: str, centre: tuple[float, float], count: int, spread_m: float, seed: int) -> Thing:
    """Return a grazing flock."""
    rng = generator(seed, 33, count)
    places = np.asarray(centre) + rng.normal(0.0, spread_m, (count, 2))
    body: list[Mark] = []
    shadow: list[Mark] = []
    for place in places:
        yaw = rng.uniform(0.0, 2.0 * np.pi)
        heading = np.array([np.cos(yaw), np.sin(yaw)])
        wool = Paint((226, 220, 204), 60).lit(rng.uniform(0.9, 1.05))
        body += [disc(place + heading * step, 0.33, wool) for step in (-0.32, 0.0, 0.32)]
        body.append(disc(place + heading * 0.74, 0.15, Paint((44, 40, 38), 10)))
        shadow += [
            disc(place + heading * step + shadow_offset(0.6), 0.36, wool) for step in (-0.3, 0.3)
        ]
    return Thing(
        name=name,
        kind='sheep',
        placing=Placing(*centre),
        size_m=(1.2, 0.7, 0.0),
        shadow=tuple(shadow),
        body=tuple(body),
    )


def _grouped(outlines: list[Points], size: int, paint: Paint) -> list[Mark]:
    """Return polygons painted `size` at a time: fewer strokes of the brush than one by one."""
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


def _field(name: str, corners: Points, ground: list[Mark]) -> Thing:
    east, north = corners.mean(axis=0).tolist()
    return Thing(
        name=name,
        kind='field',
        placing=Placing(east, north),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(ground),
    )
