# SPDX-License-Identifier: Apache-2.0
"""Houses, barns and tents: x along the ridge, z = 0 on the ground."""

import math
from collections.abc import Iterator

from rocsafe_scene.mesh.mesh import Colour, Mesh, joined
from rocsafe_scene.mesh.shapes import box, cylinder, prism, sheet, tube
from rocsafe_scene.mesh.surfaces import Surface

_FRAME: Colour = (232, 230, 222)
_GLASS: Colour = (40, 48, 56)


def house(
    length: float = 11.0,
    width: float = 7.6,
    eaves: float = 2.9,
    wall: Colour = (222, 214, 196),
    roof: Colour = (104, 62, 50),
) -> Mesh:
    """Return a house with a gabled, tiled roof, windows, a door and a chimney."""
    ridge = eaves + 0.42 * width
    parts = [*_shell(length, width, (eaves, ridge), wall, roof)]
    for side in (-1.0, 1.0):
        y = side * 0.5 * width
        for k in range(max(2, int(length / 3.2))):
            x = (k + 0.5) * length / max(2, int(length / 3.2)) - 0.5 * length
            parts += [mesh.moved(x, y) for mesh in _window(1.1, 1.2, 0.95, side)]
    door = box(1.0, 0.08, 2.05).moved(0.5, -0.5 * width, 0.0)
    parts.append(door.painted((58, 84, 70), Surface.PAINT))
    stack = box(0.7, 0.6, 1.9).moved(-0.32 * length, 0.0, ridge - 1.0)
    parts.append(stack.painted((142, 88, 66), Surface.STONE))
    for y in (-0.14, 0.14):
        pot = cylinder(0.11, 0.4).turned(pitch_deg=90.0).moved(-0.32 * length, y, ridge + 1.05)
        parts.append(pot.painted((168, 100, 66), Surface.STONE))
    return joined(parts)


def _shell(
    length: float, width: float, heights: tuple[float, float], wall: Colour, roof: Colour
) -> Iterator[Mesh]:
    eaves, ridge = heights
    gable = [(-0.5 * width, -0.6), (0.5 * width, -0.6), (0.5 * width, eaves), (0.0, ridge),
             (-0.5 * width, eaves)]  # fmt: skip
    yield prism(gable, length).turned(yaw_deg=90.0).painted(wall, Surface.STONE)
    over, slope = 0.45, (ridge - eaves) / (0.5 * width)
    for side in (-1.0, 1.0):
        low = (side * (0.5 * width + over), eaves - slope * over)
        yield from _slope(length + 0.7, low, ridge, side, roof)
        gutter = cylinder(0.07, length + 0.7).moved(0.0, low[0], low[1] + 0.04)
        yield gutter.painted((70, 70, 72), Surface.PAINT)
    cap = cylinder(0.13, length + 0.7).moved(z=ridge + 0.12)
    yield cap.painted(_toned(roof, 0.85), Surface.TILE)


def _slope(
    length: float, low: tuple[float, float], ridge: float, side: float, colour: Colour
) -> Iterator[Mesh]:
    """Yield one side of a roof as overlapping rows of tiles."""
    rows = max(6, int(abs(low[0]) / 0.34))
    for row in range(rows):
        a, b = row / rows, (row + 1.12) / rows
        lift, half = 0.07, 0.5 * length
        y0, z0 = low[0] * (1.0 - a), low[1] + (ridge - low[1]) * a + lift
        y1, z1 = low[0] * (1.0 - min(b, 1.0)), low[1] + (ridge - low[1]) * min(b, 1.0) + 0.02
        corners = [(-half, y0, z0), (half, y0, z0), (half, y1, z1), (-half, y1, z1)]
        edge = [(-half, y0, z0 - 0.06), (half, y0, z0 - 0.06), (half, y0, z0), (-half, y0, z0)]
        tone = _toned(colour, 0.92 + 0.05 * ((row * 5) % 4))
        for face in (corners, edge):
            yield sheet(face[:: -1 if side > 0.0 else 1]).painted(tone, Surface.TILE)
    under = [
        (-0.5 * length, *low),
        (0.5 * length, *low),
        (0.5 * length, 0.0, ridge),
        (-0.5 * length, 0.0, ridge),
    ]
    yield sheet(under[:: 1 if side > 0.0 else -1]).painted((90, 80, 70), Surface.WOOD)


def _window(width: float, height: float, sill: float, side: float) -> Iterator[Mesh]:
    """Yield a window in the plane y = 0 that looks to `side`."""
    yield (
        box(width + 0.16, 0.1, height + 0.16)
        .moved(0.0, 0.0, sill - 0.08)
        .painted(_FRAME, Surface.PAINT)
    )
    yield box(width, 0.12, height).moved(0.0, side * 0.01, sill).painted(_GLASS, Surface.GLASS)
    yield box(0.05, 0.14, height).moved(0.0, side * 0.01, sill).painted(_FRAME, Surface.PAINT)
    yield (
        box(width + 0.3, 0.3, 0.07)
        .moved(0.0, 0.0, sill - 0.12)
        .painted((180, 176, 168), Surface.STONE)
    )


def barn(length: float = 17.0, width: float = 10.0, eaves: float = 4.6) -> Mesh:
    """Return a barn of corrugated sheet with a big door."""
    ridge = eaves + 0.26 * width
    gable = [(-0.5 * width, -0.6), (0.5 * width, -0.6), (0.5 * width, eaves), (0.0, ridge),
             (-0.5 * width, eaves)]  # fmt: skip
    parts = [prism(gable, length).turned(yaw_deg=90.0).painted((126, 118, 104), Surface.STONE)]
    waves = int(length / 0.5)
    for side in (-1.0, 1.0):
        y, z = side * (0.5 * width + 0.4), eaves - 0.2
        for k in range(waves):
            x0 = -0.5 * length - 0.2 + k * (length + 0.4) / waves
            x1 = x0 + (length + 0.4) / waves
            lift = 0.05 if k % 2 else 0.12
            face = [
                (x0, y, z + lift),
                (x1, y, z + lift),
                (x1, 0.0, ridge + lift),
                (x0, 0.0, ridge + lift),
            ]
            tone = _toned((140, 138, 132), 0.94 + 0.06 * ((k * 3) % 4 == 0))
            parts.append(sheet(face[:: -1 if side > 0.0 else 1]).painted(tone, Surface.PAINT))
    door = box(4.0, 0.1, 3.9).turned(yaw_deg=90.0).moved(0.5 * length, 0.0, 0.0)
    parts.append(door.painted((70, 96, 78), Surface.PAINT))
    return joined(parts)


def tent(length: float = 9.0, width: float = 6.0, colour: Colour = (66, 104, 160)) -> Mesh:
    """Return an inflatable tent with arched ribs."""
    arc = [math.pi * k / 16 for k in range(17)]
    half = 0.5 * width
    shape = [(half * math.cos(a), 2.9 * math.sin(a) ** 0.8) for a in arc]
    cover = prism(shape, length).turned(yaw_deg=90.0).painted(colour, Surface.CLOTH)
    parts = [cover]
    for k in range(5):
        x = (k / 4.0 - 0.5) * length
        rib = [(x, half * math.cos(a) * 1.02, 2.96 * math.sin(a) ** 0.8) for a in arc]
        parts.append(tube(rib, 0.19, 10).painted(_toned(colour, 0.8), Surface.CLOTH))
    for end in (-1.0, 1.0):
        flap = box(0.06, 2.2, 2.1).moved(end * (0.5 * length + 0.02), 0.0, 0.0)
        parts.append(flap.painted(_toned(colour, 0.6), Surface.CLOTH))
    return joined(parts)


def _toned(colour: Colour, factor: float) -> Colour:
    red, green, blue = (min(255, max(0, round(part * factor))) for part in colour)
    return red, green, blue
