# SPDX-License-Identifier: Apache-2.0
"""Small objects: debris, drums, cones, evidence markers, tape, fences, rails and sleepers."""

import math
from itertools import pairwise

import numpy as np

from rocsafe_scene.mesh.mesh import Colour, Floats, Mesh, joined, made, unit
from rocsafe_scene.mesh.shapes import ball, box, cylinder, prism, sheet, strip, tube, upright
from rocsafe_scene.mesh.surfaces import Surface
from rocsafe_scene.parts.lettering import digits

# Half of a Vignole rail's outline: aside and up from its foot, metres.
_RAIL = ((0.075, 0.0), (0.012, 0.035), (0.012, 0.11), (0.036, 0.12), (0.036, 0.159))
RAIL_SECTION = (*_RAIL, *((-y, z) for y, z in reversed(_RAIL)))
_SLEEPER_M = 0.65
GAUGE_M = 1.602


def drum(colour: Colour = (36, 84, 150)) -> Mesh:
    """Return a 200 litre steel drum, upright."""
    parts = [upright(0.29, 0.88, 24).painted(colour, Surface.PAINT)]
    for z in (0.01, 0.29, 0.57, 0.84):
        hoop = upright(0.305, 0.035, 24).moved(z=z)
        parts.append(hoop.painted(colour, Surface.PAINT))
    parts.append(upright(0.05, 0.02).moved(0.17, 0.0, 0.88).painted((40, 40, 42), Surface.STEEL))
    return joined(parts)


def crate(size: float = 0.8) -> Mesh:
    """Return a slatted wooden crate."""
    parts = [box(size, 0.8 * size, 0.7 * size).painted((150, 118, 78), Surface.WOOD)]
    for z in (0.04, 0.3, 0.56):
        for side in (-1.0, 1.0):
            slat = box(1.03 * size, 0.03, 0.11 * size).moved(0.0, side * 0.41 * size, z * size)
            parts.append(slat.painted((172, 138, 94), Surface.WOOD))
    return joined(parts)


def cone() -> Mesh:
    """Return a traffic cone."""
    return joined(
        [
            box(0.42, 0.42, 0.04).painted((40, 40, 42), Surface.RUBBER),
            upright(0.15, 0.7, 16, 0.03).moved(z=0.03).painted((230, 84, 24), Surface.PAINT),
            upright(0.112, 0.16, 16, 0.084).moved(z=0.28).painted((240, 240, 236), Surface.PAINT),
        ]
    )


def evidence_marker(number: int = 1) -> Mesh:
    """Return a folded yellow plate with a number, 0.2 m high."""
    plate = prism([(-0.09, 0.0), (0.09, 0.0), (0.0, 0.2)], 0.18)
    parts = [plate.painted((250, 214, 20), Surface.PAINT)]
    for mesh in digits(str(number), 0.13):
        parts.append(
            mesh.turned(roll_deg=0.0)
            .turned(yaw_deg=-90.0)
            .turned(pitch_deg=-24.0)
            .moved(0.05, 0.0, 0.09)
        )
    return joined(parts)


def debris(rng: np.random.Generator, size: float = 0.6) -> Mesh:
    """Return a piece of torn wreckage: a bent sheet, a beam or a broken board."""
    kind = int(rng.integers(4))
    if kind == 0:
        return _bent_sheet(rng, size)
    if kind == 1:
        bend = [(0.0, 0.0, 0.05), (0.8 * size, 0.1 * size, 0.12), (1.5 * size, 0.45 * size, 0.2)]
        return tube(bend, 0.05 + 0.03 * size, 7).painted((92, 70, 56), Surface.RUSTY)
    if kind == 2:
        board = box(1.6 * size, 0.22, 0.05, 0.005).turned(pitch_deg=float(rng.uniform(-14, 14)))
        return board.moved(z=0.08).painted((150, 120, 86), Surface.WOOD)
    block = box(size, 0.6 * size, 0.4 * size, 0.05 * size)
    points = block.points * (1.0 + rng.normal(0.0, 0.12, (len(block.points), 3)))
    tone: Colour = tuple(int(v) for v in rng.choice([(120, 116, 110), (96, 62, 46), (66, 64, 62)]))  # type: ignore[assignment]
    return Mesh(
        points=points, normals=block.normals, places=block.places, colours=block.colours,
        triangles=block.triangles,
    ).painted(tone, Surface.RUSTY)  # fmt: skip


def _bent_sheet(rng: np.random.Generator, size: float) -> Mesh:
    """Return a crumpled metal sheet with two sides."""
    count = 9
    axis = np.linspace(-size, size, count)
    x, y = np.meshgrid(axis, 0.7 * axis)
    z = 0.06 + 0.3 * size * np.abs(np.sin(1.6 * x / size + 0.9 * y / size + rng.uniform(0.0, 6.0)))
    z = z + rng.normal(0.0, 0.03 * size, z.shape)
    x, y = x + rng.normal(0.0, 0.05 * size, x.shape), y + rng.normal(0.0, 0.05 * size, y.shape)
    points = np.column_stack([x.ravel(), y.ravel(), np.maximum(z.ravel(), 0.02)])
    slope_y, slope_x = np.gradient(z, 1.4 * size / (count - 1), 2.0 * size / (count - 1))
    normals = np.column_stack([-slope_x.ravel(), -slope_y.ravel(), np.ones(count * count)])
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    b, c, d = a + 1, a + count + 1, a + count
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    face = made(points, normals, points[:, :2], triangles)
    grey = int(rng.integers(70, 140))
    both = joined([face, face.flipped().moved(z=-0.006)])
    return both.painted((grey, grey, grey + 3), Surface.RUSTY)


def tape(course: Floats, height: float = 0.95) -> Mesh:
    """Return red and white barrier tape on posts along `course` (k, 3)."""
    parts = []
    for foot in course:
        post = upright(0.03, height + 0.1, 8).moved(*foot)
        parts.append(post.painted((226, 90, 30), Surface.PAINT))
    for start, end in pairwise(course):
        span = np.linspace(start, end, max(2, int(np.linalg.norm(end - start) / 0.5) + 1))
        sag = 0.14 * np.sin(np.linspace(0.0, math.pi, len(span)))
        span = span + np.column_stack([np.zeros((len(span), 2)), height - sag])
        for number, (one, two) in enumerate(pairwise(span)):
            colour = (214, 30, 34) if number % 2 else (240, 240, 236)
            parts.append(_ribbon(one, two).painted(colour, Surface.CLOTH))
    return joined(parts)


def _ribbon(start: Floats, end: Floats) -> Mesh:
    """Return a piece of tape, tilted so that it is seen from above too, with two sides."""
    side = unit(np.array([[end[1] - start[1], start[0] - end[0], 0.0]]))[0] * 0.04
    lift = np.array([0.0, 0.0, 0.05])
    face = sheet([start - side - lift, end - side - lift, end + side + lift, start + side + lift])
    return joined([face, face.flipped()])


def fence(course: Floats, height: float = 1.1) -> Mesh:
    """Return a post and wire fence along `course` (k, 3)."""
    parts = [
        box(0.1, 0.1, height).moved(*foot).painted((128, 110, 88), Surface.WOOD) for foot in course
    ]
    for z in (0.4, 0.7, 1.0):
        wire = tube(course + np.array([0.0, 0.0, z * height]), 0.012, 4)
        parts.append(wire.painted((150, 150, 148), Surface.STEEL))
    return joined(parts)


def rails(course: Floats) -> Mesh:
    """Return both rails of a track over `course` (k, 3), the top of its sleepers."""
    ahead = unit(np.gradient(course, axis=0) * np.array([1.0, 1.0, 0.0]))
    left = np.column_stack([-ahead[:, 1], ahead[:, 0], np.zeros(len(course))])
    parts = []
    for side in (-0.5, 0.5):
        rail = strip(course + side * GAUGE_M * left, RAIL_SECTION)
        colours = rail.colours.copy()
        is_top = rail.normals[:, 2] > 0.9
        colours[:, :3] = np.where(is_top[:, None], (176, 176, 178), (92, 64, 50))
        colours[:, 3] = np.where(is_top, Surface.STEEL, Surface.RUSTY)
        parts.append(
            Mesh(points=rail.points, normals=rail.normals, places=rail.places, colours=colours,
                 triangles=rail.triangles)
        )  # fmt: skip
    return joined(parts)


def sleepers(rng: np.random.Generator, course: Floats) -> Mesh:
    """Return sleepers under `course` (k, 3), their tops on it."""
    steps = np.linalg.norm(np.diff(course, axis=0), axis=1)
    run = np.concatenate([[0.0], np.cumsum(steps)])
    parts = []
    for along in np.arange(0.3, run[-1], _SLEEPER_M):
        place = np.array([np.interp(along, run, course[:, k]) for k in range(3)])
        ahead = [np.interp(along, run, np.gradient(course[:, k])) for k in range(2)]
        yaw = math.degrees(math.atan2(ahead[1], ahead[0])) + float(rng.normal(0.0, 0.6))
        tone = int(rng.normal(98.0, 12.0))
        board = box(0.25, 2.6, 0.16, 0.02).turned(yaw_deg=yaw).moved(*place).moved(z=-0.16)
        parts.append(board.painted((tone, round(0.9 * tone), round(0.78 * tone)), Surface.WOOD))
    return joined(parts)


def stones(rng: np.random.Generator, places: Floats, size: float = 0.07) -> Mesh:
    """Return loose stones at `places` (n, 3)."""
    parts = []
    for place in places:
        scale = size * rng.uniform(0.5, 1.6, 3)
        tone = int(rng.normal(132.0, 22.0))
        stone = ball(1.0, 6).scaled(*scale).turned(float(rng.uniform(0, 360)))
        parts.append(stone.moved(*place).painted((tone, tone, max(0, tone - 6)), Surface.STONE))
    return joined(parts)


def barrier_pole(length: float = 5.0) -> Mesh:
    """Return a lowered level crossing barrier with its post."""
    parts = [box(0.3, 0.3, 1.1).painted((180, 180, 176), Surface.PAINT)]
    for k in range(int(length)):
        colour = (214, 30, 34) if k % 2 else (240, 240, 236)
        pole = cylinder(0.05, 1.0).moved(0.5 + k, 0.0, 1.0)
        parts.append(pole.painted(colour, Surface.PAINT))
    return joined(parts)
