# SPDX-License-Identifier: Apache-2.0
"""Railway vehicles: x ahead, y left, z = 0 on the rails."""

import math
from collections.abc import Iterator

from rocsafe_scene.mesh.mesh import Colour, Mesh, joined
from rocsafe_scene.mesh.shapes import box, cylinder, lathe, prism, tank, tube, upright
from rocsafe_scene.mesh.surfaces import Surface
from rocsafe_scene.parts.lettering import placard, stripes

GAUGE_M = 1.602
_WHEEL_M = 0.46
_FRAME: Colour = (52, 46, 42)
_STEEL: Colour = (112, 108, 104)
_RUST: Colour = (96, 62, 44)
_GRATING: Colour = (140, 138, 132)


def bogie() -> Mesh:
    """Return a two-axled bogie about the origin."""
    parts = [
        box(2.5, 0.12, 0.26).moved(0.0, side * 0.98, 0.42).painted(_FRAME, Surface.RUSTY)
        for side in (-1.0, 1.0)
    ]
    parts.append(box(0.6, 2.0, 0.24).moved(z=0.5).painted(_FRAME, Surface.RUSTY))
    for x in (-0.9, 0.9):
        axle = cylinder(0.07, 1.7).turned(yaw_deg=90.0).moved(x, 0.0, _WHEEL_M)
        parts.append(axle.painted(_STEEL, Surface.STEEL))
        for side in (-1.0, 1.0):
            wheel = cylinder(_WHEEL_M, 0.13, 24, 0.03).turned(yaw_deg=90.0)
            place = wheel.moved(x, side * 0.5 * GAUGE_M, _WHEEL_M)
            parts.append(place.painted(_RUST, Surface.RUSTY))
            box_ = box(0.3, 0.16, 0.3).moved(x, side * 1.06, 0.32)
            parts.append(box_.painted(_FRAME, Surface.RUSTY))
    return joined(parts)


def _buffers(length_m: float) -> Iterator[Mesh]:
    for end in (-1.0, 1.0):
        for side in (-1.0, 1.0):
            stem = cylinder(0.08, 0.5).moved(end * (0.5 * length_m + 0.15), side * 0.88, 1.02)
            yield stem.painted(_STEEL, Surface.STEEL)
            plate = cylinder(0.24, 0.06).moved(end * (0.5 * length_m + 0.4), side * 0.88, 1.02)
            yield plate.painted(_FRAME, Surface.STEEL)
        hook = box(0.5, 0.1, 0.12).moved(end * (0.5 * length_m + 0.2), 0.0, 0.95)
        yield hook.painted(_FRAME, Surface.RUSTY)


def underframe(length_m: float, colour: Colour = _FRAME) -> Mesh:
    """Return frame, bogies and buffers of a wagon."""
    parts = [
        box(length_m, 0.2, 0.34).moved(0.0, side * 1.1, 0.92).painted(colour, Surface.RUSTY)
        for side in (-1.0, 1.0)
    ]
    parts += [
        box(0.18, 2.5, 0.36).moved(x * 0.5 * (length_m - 0.2), 0.0, 0.9)
        .painted(colour, Surface.RUSTY)
        for x in (-1.0, -0.5, 0.0, 0.5, 1.0)
    ]  # fmt: skip
    parts += [bogie().moved(side * (0.5 * length_m - 2.1)) for side in (-1.0, 1.0)]
    parts.append(cylinder(0.18, 1.2).moved(1.4, -0.5, 0.7).painted(_FRAME, Surface.PAINT))
    parts.append(box(0.9, 0.4, 0.5).moved(-1.5, 0.8, 0.5).painted(_FRAME, Surface.PAINT))
    return joined([*parts, *_buffers(length_m)])


def tank_car(colour: Colour = (198, 200, 202), number: str = '33/1203') -> Mesh:
    """Return a four-axled tank wagon, 14 m long, with hazard placards of `number`."""
    radius, length = 1.42, 13.0
    body = tank(radius, length, 0.55, 48).moved(z=2.62).painted(colour, Surface.PAINT)
    parts = [underframe(13.4), body]
    for x in (-4.6, -1.6, 1.6, 4.6):
        band = lathe([(-0.06, radius + 0.012), (0.06, radius + 0.012)], 48).moved(x, 0.0, 2.62)
        parts.append(band.painted(_darker(colour, 0.72), Surface.PAINT))
        saddle = prism([(-0.25, 0.0), (0.25, 0.0), (0.15, 0.5), (-0.15, 0.5)], 2.1)
        parts.append(saddle.moved(x, 0.0, 1.1).painted(_FRAME, Surface.RUSTY))
    parts += _tank_top(radius)
    for side in (-1.0, 1.0):
        sign = placard(number).turned(yaw_deg=90.0 - 90.0 * side)
        parts.append(sign.turned(roll_deg=-14.0 * side).moved(3.1, side * (radius + 0.01), 2.1))
        parts.append(_ladder(side, radius))
    return joined(parts)


def _tank_top(radius: float) -> Iterator[Mesh]:
    """Yield manholes, the walkway along the top and its rails."""
    top = 2.62 + radius
    for x in (-3.4, 0.0, 3.4):
        yield upright(0.3, 0.24, 20).moved(x, 0.0, top - 0.04).painted(_STEEL, Surface.STEEL)
        yield upright(0.36, 0.05, 20).moved(x, 0.0, top + 0.2).painted(_FRAME, Surface.PAINT)
    for y in (-0.62, 0.62):
        yield box(9.6, 0.42, 0.04).moved(0.0, y, top - 0.06).painted(_GRATING, Surface.STEEL)
    for y in (-0.84, 0.84):
        rail = tube([(-4.8, y, top + 0.5), (4.8, y, top + 0.5)], 0.025, 6)
        yield rail.painted((206, 170, 40), Surface.PAINT)
        for k in range(7):
            post = tube([(-4.8 + 1.6 * k, y, top - 0.1), (-4.8 + 1.6 * k, y, top + 0.5)], 0.02, 5)
            yield post.painted((206, 170, 40), Surface.PAINT)


def _ladder(side: float, radius: float) -> Mesh:
    y = side * (radius + 0.14)
    rails = [
        tube([(x, y, 1.0), (x, y, 3.1), (x, side * 0.8, 4.1)], 0.025, 5) for x in (-0.25, 0.2)
    ]
    rungs = [
        tube([(-0.25, y, z), (0.2, y, z)], 0.018, 5) for z in (1.2, 1.55, 1.9, 2.25, 2.6, 2.95)
    ]
    return joined([*rails, *rungs]).painted(_STEEL, Surface.STEEL)


def flat_car(colour: Colour = (92, 66, 50)) -> Mesh:
    """Return a flat wagon, 13 m long, with a plank deck and stanchions."""
    parts = [underframe(12.8, colour)]
    for k in range(32):
        tone = 0.86 + 0.05 * ((k * 7) % 5)
        plank = box(0.385, 2.6, 0.06, 0.01).moved(-6.2 + 0.4 * k, 0.0, 1.26)
        parts.append(plank.painted(_darker((128, 100, 74), tone), Surface.WOOD))
    for x in (-5.4, -2.7, 0.0, 2.7, 5.4):
        for side in (-1.0, 1.0):
            post = box(0.1, 0.1, 0.9).moved(x, side * 1.34, 1.0)
            parts.append(post.painted(_darker(colour, 0.8), Surface.RUSTY))
    return joined(parts)


def box_car(colour: Colour = (124, 66, 46)) -> Mesh:
    """Return a covered wagon, 13 m long, ribbed, with a rounded roof and sliding doors."""
    length, width, height = 12.6, 2.72, 2.5
    parts = [underframe(12.8)]
    body = box(length, width, height, 0.04).moved(z=1.24)
    parts.append(body.painted(colour, Surface.RUSTY))
    rise = [(math.cos(a) * 0.5 * width, math.sin(a) * 0.38) for a in _arc(11)]
    roof = prism(rise, length + 0.12).turned(yaw_deg=90.0).moved(z=1.22 + height)
    parts.append(roof.painted(_darker((150, 146, 140), 0.9), Surface.RUSTY))
    for k in range(22):
        x = -0.5 * length + 0.3 + 0.571 * k
        for side in (-1.0, 1.0):
            rib = box(0.09, 0.07, height - 0.1).moved(x, side * (0.5 * width + 0.02), 1.29)
            parts.append(rib.painted(_darker(colour, 0.86), Surface.RUSTY))
        seam = [
            (x, math.cos(a) * (0.5 * width + 0.02), 3.72 + math.sin(a) * 0.41) for a in _arc(9)
        ]
        parts.append(tube(seam, 0.03, 5).painted((126, 122, 116), Surface.RUSTY))
    for side in (-1.0, 1.0):
        door = box(2.6, 0.08, height - 0.2).moved(0.4, side * (0.5 * width + 0.06), 1.32)
        parts.append(door.painted(_darker(colour, 1.12), Surface.PAINT))
    return joined(parts)


def _arc(count: int) -> list[float]:
    return [math.pi * k / (count - 1) for k in range(count)]


def locomotive(colour: Colour = (228, 116, 30)) -> Mesh:
    """Return a diesel locomotive, 18 m long, with a cab at each end."""
    parts = [underframe(18.0), *_loco_body(colour), *_loco_roof(), *_loco_cabs()]
    for side in (-1.0, 1.0):
        parts.append(
            box(17.2, 0.03, 0.34)
            .moved(0.0, side * 1.38, 1.36)
            .painted((40, 40, 44), Surface.PAINT)
        )
        for k in range(6):
            louvre = box(0.9, 0.04, 0.8).moved(-4.2 + 1.5 * k, side * 1.38, 2.2)
            parts.append(louvre.painted((54, 54, 56), Surface.STEEL))
    return joined(parts)


def _loco_body(colour: Colour) -> Iterator[Mesh]:
    yield box(17.4, 2.76, 0.5, 0.05).moved(z=0.95).painted((46, 46, 50), Surface.PAINT)
    side = [(-7.0, 1.3), (7.0, 1.3), (7.0, 3.5), (6.7, 3.78), (-6.7, 3.78), (-7.0, 3.5)]
    yield prism(side, 2.62).painted(colour, Surface.PAINT)
    yield prism([(-6.6, 3.7), (6.6, 3.7), (6.4, 3.98), (-6.4, 3.98)], 2.1).painted(
        (92, 92, 94), Surface.PAINT
    )
    yield cylinder(0.62, 3.2).moved(0.0, 0.0, 0.72).painted((60, 56, 52), Surface.RUSTY)


def _loco_cabs() -> Iterator[Mesh]:
    nose = [(0.0, 1.3), (1.9, 1.3), (1.9, 2.35), (1.35, 3.5), (0.9, 3.72), (0.0, 3.72)]
    glass = [(1.42, 3.42), (1.88, 2.44), (1.92, 2.44), (1.46, 3.42)]
    for end in (0.0, 180.0):
        for mesh, colour, surface in (
            (prism(nose, 2.62), (238, 190, 36), Surface.PAINT),
            (prism(glass, 2.2), (26, 32, 38), Surface.GLASS),
            (box(0.9, 2.66, 0.62).moved(0.75, 0.0, 2.6), (28, 34, 40), Surface.GLASS),
            (box(0.1, 0.3, 0.2).moved(1.88, 0.9, 1.7), (250, 246, 226), Surface.LAMP),
            (box(0.1, 0.3, 0.2).moved(1.88, -0.9, 1.7), (250, 246, 226), Surface.LAMP),
        ):
            yield mesh.moved(6.8).turned(yaw_deg=end).painted(colour, surface)


def _loco_roof() -> Iterator[Mesh]:
    for x in (-4.0, -2.2, 2.2, 4.0):
        yield upright(0.62, 0.16, 24).moved(x, 0.0, 3.94).painted((44, 44, 46), Surface.STEEL)
        for blade in range(5):
            yield (
                box(1.0, 0.16, 0.03).turned(yaw_deg=36.0 * blade).moved(x, 0.0, 4.1)
                .painted((118, 118, 118), Surface.STEEL)
            )  # fmt: skip
    yield box(1.3, 0.5, 0.3).moved(0.0, 0.0, 3.94).painted((66, 60, 56), Surface.RUSTY)
    yield upright(0.16, 0.45).moved(0.5, 0.0, 3.98).painted((40, 36, 34), Surface.RUSTY)


# Half of a cooling fin: along and outwards, metres.
_FIN = ((-0.03, 0.9), (-0.03, 1.1), (-0.03, 1.1), (0.03, 1.1), (0.03, 1.1), (0.03, 0.9))


def flask(colour: Colour = (226, 178, 32)) -> Mesh:
    """Return a transport flask for radioactive material: finned cylinder, shock absorbers."""
    parts = [cylinder(0.98, 2.5, 40).painted(colour, Surface.PAINT)]
    for x in (-1.45, 1.45):
        parts.append(cylinder(1.22, 0.72, 40, 0.1).moved(x).painted((188, 40, 34), Surface.PAINT))
    parts += [
        lathe(_FIN, 40)
        .moved(x).painted(_darker(colour, 0.82), Surface.PAINT)
        for x in (-0.9, -0.6, -0.3, 0.0, 0.3, 0.6, 0.9)
    ]  # fmt: skip
    for x in (-0.8, 0.8):
        trunnion = cylinder(0.14, 2.5).turned(yaw_deg=90.0).moved(x)
        parts.append(trunnion.painted(_STEEL, Surface.STEEL))
    return joined([joined(parts).moved(z=1.24), *stripes(2.6, 1.5)])


def flask_car(count: int = 1) -> Mesh:
    """Return a flat wagon with up to three flasks."""
    places = {1: (0.0,), 2: (-3.0, 3.0), 3: (-4.1, 0.0, 4.1)}
    if count not in places:
        raise ValueError(f'count is {count}: must be 1 to 3')
    flasks = [flask().moved(x, 0.0, 1.42) for x in places[count]]
    return joined([flat_car(), *flasks])


def _darker(colour: Colour, factor: float) -> Colour:
    red, green, blue = (min(255, max(0, round(part * factor))) for part in colour)
    return red, green, blue
