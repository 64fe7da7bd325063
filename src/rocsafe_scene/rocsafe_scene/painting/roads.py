# SPDX-License-Identifier: Apache-2.0
"""Paint of roads, tracks and streams."""

from rocsafe_scene.painting.marks import Coordinates, Mark, Paint, Points, disc, normals_of, stroke
from rocsafe_scene.painting.outlines import generator, smooth_line

_VERGE = Paint((112, 116, 70), 140, 0.5)
_ASPHALT = Paint((101, 101, 104), 55)
_WORN = Paint((118, 117, 116), 60, 0.4)
_PATCH = Paint((76, 76, 80), 50, 0.7)
_LINE = Paint((222, 222, 212), 30, 0.85)
_GRAVEL = Paint((154, 143, 118), 170)
_RUT = Paint((126, 112, 88), 150, 0.5)
_WATER = Paint((58, 76, 75), 25)
_DEEP = Paint((44, 60, 62), 20)
_BANK = Paint((70, 82, 44), 160, 0.7)
_REEDS = Paint((120, 124, 66), 190, 0.8)


def road(points: Coordinates, width_m: float, seed: int) -> tuple[Mark, ...]:
    """Return an asphalt road with edge lines, a broken centre line and repairs."""
    line = smooth_line(points, 3.0)
    rng = generator(seed, 21, 4)
    ground: list[Mark] = [stroke(line, width_m + 2.4, _VERGE), stroke(line, width_m, _ASPHALT)]
    for lane in (-0.25, 0.25):
        for track in (-0.75, 0.75):
            ground.append(stroke(_beside(line, lane * width_m + track), 0.5, _WORN))
    for _ in range(len(line) // 4):
        at = int(rng.integers(1, len(line) - 2))
        piece = _beside(line[at : at + 3], rng.uniform(-0.3, 0.3) * width_m)
        ground.append(stroke(piece, rng.uniform(0.7, 1.8), _PATCH))
    for side in (-1.0, 1.0):
        ground.append(stroke(_beside(line, side * (0.5 * width_m - 0.25)), 0.12, _LINE))
    dashes = smooth_line(points, 1.0)
    for at in range(0, len(dashes) - 3, 8):
        ground.append(stroke(dashes[at : at + 4], 0.12, _LINE))
    return tuple(ground)


def gravel_track(points: Coordinates, width_m: float, seed: int) -> tuple[Mark, ...]:
    """Return a gravel track with two ruts and grass creeping in."""
    line = smooth_line(points, 2.0)
    rng = generator(seed, 22, 5)
    ground: list[Mark] = [
        stroke(line, width_m + 1.2, _VERGE),
        stroke(line + rng.normal(0.0, 0.12, line.shape), width_m, _GRAVEL),
    ]
    for side in (-0.85, 0.85):
        rut = _beside(line, side) + rng.normal(0.0, 0.06, line.shape)
        ground.append(stroke(rut, 0.55, _RUT))
    return tuple(ground)


def stream(points: Coordinates, width_m: float, seed: int) -> tuple[Mark, ...]:
    """Return a stream with banks and reeds."""
    line = smooth_line(points, 2.0)
    rng = generator(seed, 23, 6)
    wavy = line + rng.normal(0.0, 0.16, line.shape)
    ground: list[Mark] = [
        stroke(wavy, width_m + 3.2, _BANK),
        stroke(wavy, width_m + 1.0, Paint((92, 85, 58), 150)),
        stroke(wavy, width_m, _WATER),
        stroke(_beside(wavy, 0.2), 0.5 * width_m, _DEEP),
    ]
    for _ in range(len(line) * 3):
        at = line[int(rng.integers(len(line)))]
        side = rng.choice([-1.0, 1.0]) * (0.5 * width_m + rng.uniform(0.2, 1.4))
        place = at + rng.normal(0.0, 1.0, 2) + [0.0, side]
        ground.append(disc(place, rng.uniform(0.1, 0.3), _REEDS.lit(rng.uniform(0.7, 1.1))))
    return tuple(ground)


def _beside(line: Points, offset_m: float) -> Points:
    return line + offset_m * normals_of(line)
