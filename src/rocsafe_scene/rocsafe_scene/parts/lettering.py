# SPDX-License-Identifier: Apache-2.0
"""Signs on vehicles: hazard placards with digits, warning stripes, the trefoil."""

import math
from collections.abc import Iterator

from rocsafe_scene.mesh.mesh import Colour, Mesh, joined
from rocsafe_scene.mesh.shapes import box, sheet
from rocsafe_scene.mesh.surfaces import Surface

_ORANGE: Colour = (236, 112, 26)
_BLACK: Colour = (22, 22, 24)
_THICK_M = 0.006
# The seven segments of a digit in a cell 1 wide and 2 high: x, z of the middle; is upright.
_SEGMENTS = {
    'a': (0.0, 1.0, False), 'b': (0.5, 0.5, True), 'c': (0.5, -0.5, True), 'd': (0.0, -1.0, False),
    'e': (-0.5, -0.5, True), 'f': (-0.5, 0.5, True), 'g': (0.0, 0.0, False),
}  # fmt: skip
_DIGITS = {
    '0': 'abcdef', '1': 'bc', '2': 'abged', '3': 'abgcd', '4': 'fgbc', '5': 'afgcd',
    '6': 'afgedc', '7': 'abc', '8': 'abcdefg', '9': 'abcdfg',
}  # fmt: skip


def _plate(width: float, height: float, colour: Colour, depth: float = _THICK_M) -> Mesh:
    """Return a thin upright plate in the plane y = 0, its face towards +y, centred."""
    plate = box(width, depth, height, 0.001).moved(0.0, 0.5 * depth, -0.5 * height)
    return plate.painted(colour, Surface.PAINT)


def digits(text: str, height_m: float) -> Iterator[Mesh]:
    """Yield the black strokes of decimal `text`, centred, readable from +y."""
    cell = 0.72 * height_m
    for place, digit in enumerate(text):
        x = -(place - 0.5 * (len(text) - 1)) * cell
        for name in _DIGITS.get(digit, 'g'):
            middle_x, middle_z, is_upright = _SEGMENTS[name]
            size = (0.08, 0.5) if is_upright else (0.44, 0.08)
            stroke = _plate(size[0] * height_m, size[1] * height_m, _BLACK, 2.0 * _THICK_M)
            yield stroke.moved(x - middle_x * 0.44 * height_m, 0.0, middle_z * 0.46 * height_m)


def placard(number: str, width_m: float = 0.8) -> Mesh:
    """Return an orange plate, upright towards +y: hazard number over substance number."""
    upper, _, lower = number.partition('/')
    parts = [_plate(width_m, 0.75 * width_m, _BLACK, 0.5 * _THICK_M)]
    parts.append(_plate(0.95 * width_m, 0.7 * width_m, _ORANGE))
    parts.append(_plate(0.95 * width_m, 0.02 * width_m, _BLACK, 2.0 * _THICK_M))
    for text, z in ((upper, 0.18), (lower, -0.18)):
        parts += [mesh.moved(z=z * width_m) for mesh in digits(text, 0.27 * width_m)]
    return joined(parts)


def trefoil(radius_m: float) -> Mesh:
    """Return the radiation warning sign, flat on z = 0, towards +z."""
    ring = [_turned(radius_m, 15.0 * k) for k in range(24)]
    parts = [sheet(ring).painted((244, 202, 26), Surface.PAINT)]
    for blade in range(3):
        inner = [_turned(0.27 * radius_m, 120.0 * blade + a) for a in (60.0, 30.0, 0.0)]
        outer = [_turned(0.8 * radius_m, 120.0 * blade + a) for a in (0.0, 15.0, 30.0, 45.0, 60.0)]
        fan = sheet([*outer, *inner]).moved(z=0.006)
        parts.append(fan.painted(_BLACK, Surface.PAINT))
    middle = sheet([_turned(0.16 * radius_m, 30.0 * k) for k in range(12)]).moved(z=0.006)
    return joined([*parts, middle.painted(_BLACK, Surface.PAINT)])


def _turned(radius: float, angle_deg: float) -> tuple[float, float, float]:
    angle = math.radians(angle_deg)
    return radius * math.cos(angle), radius * math.sin(angle), 0.0


def stripes(height_m: float, length_m: float) -> Iterator[Mesh]:
    """Yield the trefoil on top of a flask of `height_m`, held by a saddle `length_m` long."""
    yield trefoil(0.52).moved(z=height_m - 0.25)
    yield (
        box(0.9 * length_m, 1.1, 0.06)
        .moved(z=height_m - 0.32)
        .painted((226, 178, 32), Surface.PAINT)
    )
    for x in (-0.45, 0.45):
        yield (
            box(0.3, 2.1, 0.7, 0.05).moved(x * length_m, 0.0, 0.0)
            .painted((64, 60, 58), Surface.RUSTY)
        )  # fmt: skip
