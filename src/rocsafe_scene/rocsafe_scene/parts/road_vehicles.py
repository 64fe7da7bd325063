# SPDX-License-Identifier: Apache-2.0
"""Road vehicles: x ahead, y left, z = 0 on the road."""

from collections.abc import Iterator, Sequence

from rocsafe_scene.mesh.mesh import Colour, Mesh, joined
from rocsafe_scene.mesh.shapes import box, cylinder, prism, tank, tube, upright
from rocsafe_scene.mesh.surfaces import Surface
from rocsafe_scene.parts.lettering import digits, placard

_GLASS: Colour = (30, 36, 42)
_TYRE: Colour = (30, 30, 32)
_BLUE: Colour = (40, 96, 240)
_GREY: Colour = (112, 114, 118)


def wheels(places: Sequence[float], track: float, radius: float, width: float) -> Iterator[Mesh]:
    """Yield the wheels of axles at `places` along x."""
    for x in places:
        for side in (-1.0, 1.0):
            tyre = cylinder(radius, width, 20, 0.04).turned(yaw_deg=90.0)
            yield tyre.moved(x, side * track, radius).painted(_TYRE, Surface.RUBBER)
            rim = cylinder(0.55 * radius, width + 0.02, 14).turned(yaw_deg=90.0)
            yield rim.moved(x, side * track, radius).painted((150, 150, 152), Surface.STEEL)


def _lamps(front: float, rear: float, half: float, height: float) -> Iterator[Mesh]:
    for side in (-1.0, 1.0):
        lamp = box(0.06, 0.34, 0.14).moved(front, side * half, height)
        yield lamp.painted((246, 244, 232), Surface.LAMP)
        lamp = box(0.06, 0.28, 0.16).moved(rear, side * half, height)
        yield lamp.painted((190, 24, 22), Surface.LAMP)


def car(colour: Colour = (150, 156, 164)) -> Mesh:
    """Return a hatchback, 4.3 m long."""
    body = [
        (-2.1, 0.3), (2.1, 0.3), (2.15, 0.62), (1.95, 0.82), (0.95, 0.96),
        (-2.0, 1.0), (-2.15, 0.7),
    ]  # fmt: skip
    cabin = [(-2.02, 0.95), (1.0, 0.93), (0.25, 1.42), (-0.3, 1.5), (-1.35, 1.46)]
    parts = [
        prism(body, 1.76).painted(colour, Surface.PAINT),
        prism(cabin, 1.5).painted(_GLASS, Surface.GLASS),
        prism([(-1.36, 1.44), (0.26, 1.4), (-0.3, 1.53), (-1.3, 1.5)], 1.46)
        .painted(colour, Surface.PAINT),
        box(0.1, 1.6, 0.2).moved(2.12, 0.0, 0.34).painted((40, 40, 42), Surface.RUBBER),
    ]  # fmt: skip
    for side in (-1.0, 1.0):
        parts.append(tube([(0.98, side * 0.74, 0.95), (0.24, side * 0.72, 1.44)], 0.04, 5)
                     .painted(colour, Surface.PAINT))  # fmt: skip
        parts.append(tube([(-1.95, side * 0.74, 0.98), (-1.36, side * 0.72, 1.47)], 0.06, 5)
                     .painted(colour, Surface.PAINT))  # fmt: skip
        parts.append(box(0.16, 0.2, 0.14).moved(0.75, side * 0.95, 0.92)
                     .painted(colour, Surface.PAINT))  # fmt: skip
    parts += wheels((-1.32, 1.34), 0.78, 0.32, 0.2)
    parts += _lamps(2.08, -2.12, 0.66, 0.62)
    return joined(parts)


def police_car() -> Mesh:
    """Return a white car with blue lamps and a chequered side."""
    parts = [car((232, 234, 236)), *_beacon(-0.45, 1.52, 1.0)]
    for k in range(8):
        colour = (34, 70, 170) if k % 2 else (238, 224, 40)
        for side in (-1.0, 1.0):
            field = box(0.44, 0.02, 0.2).moved(-1.7 + 0.46 * k, side * 0.885, 0.64)
            parts.append(field.painted(colour, Surface.PAINT))
    parts += [
        m.turned(pitch_deg=0.0, roll_deg=-90.0).moved(-0.9, 0.0, 1.5) for m in digits('17', 0.6)
    ]
    return joined(parts)


def _beacon(x: float, z: float, width: float) -> Iterator[Mesh]:
    yield box(0.28, width, 0.06).moved(x, 0.0, z).painted((60, 60, 64), Surface.PAINT)
    for side in (-1.0, 1.0):
        lamp = box(0.24, 0.38 * width, 0.12, 0.03).moved(x, side * 0.29 * width, z + 0.05)
        yield lamp.painted(_BLUE, Surface.LAMP)


def fire_engine() -> Mesh:
    """Return a pump ladder engine, 8.2 m long."""
    red: Colour = (186, 22, 24)
    cab = [(0.0, 0.55), (2.1, 0.55), (2.1, 1.6), (1.95, 2.75), (0.0, 2.75)]
    screen = [(1.93, 2.62), (2.08, 1.62), (2.13, 1.62), (1.98, 2.62)]
    parts = [
        box(7.8, 2.1, 0.36).moved(-0.1, 0.0, 0.5).painted((44, 44, 46), Surface.RUSTY),
        prism(cab, 2.44).moved(2.0).painted(red, Surface.PAINT),
        prism(screen, 2.2).moved(2.0).painted(_GLASS, Surface.GLASS),
        box(1.5, 2.48, 0.72).moved(3.05, 0.0, 1.75).painted(_GLASS, Surface.GLASS),
        box(5.6, 2.46, 2.1, 0.04).moved(-1.15, 0.0, 0.78).painted(red, Surface.PAINT),
        box(5.3, 2.1, 0.06).moved(-1.15, 0.0, 2.86).painted(_GREY, Surface.STEEL),
    ]
    for side in (-1.0, 1.0):
        for x in (-3.1, -1.7, -0.3, 1.0):
            shutter = box(1.2, 0.04, 1.3).moved(x, side * 1.23, 1.35)
            parts.append(shutter.painted((186, 188, 190), Surface.STEEL))
        band = box(7.6, 0.03, 0.22).moved(-0.1, side * 1.235, 0.98)
        parts.append(band.painted((240, 226, 60), Surface.PAINT))
    parts += _beacon(3.2, 2.78, 1.9)
    parts += [m.moved(-1.1, 0.35, 2.98) for m in ladder(6.0, 0.5)]
    parts += wheels((-2.3, 2.6), 1.05, 0.5, 0.3)
    parts += _lamps(4.1, -3.97, 0.95, 0.9)
    return joined(parts)


def ladder(length: float, width: float) -> Iterator[Mesh]:
    """Yield a lying ladder along x."""
    for side in (-1.0, 1.0):
        beam = box(length, 0.07, 0.1).moved(0.0, side * 0.5 * width)
        yield beam.painted((196, 198, 198), Surface.STEEL)
    for k in range(int(length / 0.3)):
        rung = box(0.04, width, 0.04).moved(-0.5 * length + 0.15 + 0.3 * k, 0.0, 0.03)
        yield rung.painted((176, 178, 178), Surface.STEEL)


def ambulance() -> Mesh:
    """Return a box ambulance, 6.1 m long, chequered yellow and green."""
    cab = [(0.0, 0.4), (2.3, 0.4), (2.35, 1.0), (1.5, 1.3), (0.8, 2.2), (0.0, 2.3)]
    parts = [
        prism(cab, 1.95).moved(0.85).painted((238, 222, 60), Surface.PAINT),
        prism([(0.86, 2.1), (1.48, 1.33), (1.53, 1.33), (0.92, 2.1)], 1.7).moved(0.85)
        .painted(_GLASS, Surface.GLASS),
        box(0.8, 2.0, 0.55).moved(1.3, 0.0, 1.5).painted(_GLASS, Surface.GLASS),
        box(3.9, 2.16, 2.1, 0.06).moved(-1.05, 0.0, 0.55).painted((242, 236, 210), Surface.PAINT),
    ]  # fmt: skip
    for k in range(8):
        for row in range(2):
            colour = (20, 130, 70) if (k + row) % 2 else (238, 222, 60)
            for side in (-1.0, 1.0):
                field = box(0.47, 0.02, 0.3).moved(-2.75 + 0.48 * k, side * 1.085, 0.9 + 0.3 * row)
                parts.append(field.painted(colour, Surface.PAINT))
    for x, y in ((0.5, 0.16), (0.16, 0.5)):
        parts.append(
            box(2.0 * x, 2.0 * y, 0.02)
            .moved(-1.1, 0.0, 2.65)
            .painted((20, 130, 70), Surface.PAINT)
        )
    parts += _beacon(0.6, 2.64, 1.7)
    parts += wheels((-1.9, 2.1), 0.9, 0.36, 0.24)
    parts += _lamps(3.18, -3.02, 0.8, 0.75)
    return joined(parts)


def lorry(colour: Colour = (40, 80, 140)) -> Mesh:
    """Return a lorry with a box body, 9 m long."""
    cab = [(0.0, 0.6), (1.9, 0.6), (1.9, 1.6), (1.75, 2.8), (0.0, 2.9)]
    parts = [
        *_chassis(cab, colour),
        box(6.3, 2.46, 2.5, 0.04).moved(-1.3, 0.0, 1.05).painted((214, 214, 210), Surface.PAINT),
    ]
    for k in range(9):
        rib = box(0.05, 2.48, 0.03).moved(-4.1 + 0.7 * k, 0.0, 3.54)
        parts.append(rib.painted((190, 190, 186), Surface.STEEL))
    return joined(parts)


def _chassis(cab: Sequence[tuple[float, float]], colour: Colour) -> Iterator[Mesh]:
    yield box(8.6, 1.0, 0.3).moved(-0.3, 0.0, 0.7).painted((40, 40, 42), Surface.RUSTY)
    yield prism(cab, 2.4).moved(2.1).painted(colour, Surface.PAINT)
    screen = [(1.76, 2.65), (1.88, 1.64), (1.93, 1.64), (1.82, 2.65)]
    yield prism(screen, 2.1).moved(2.1).painted(_GLASS, Surface.GLASS)
    yield box(1.0, 2.44, 0.66).moved(3.2, 0.0, 1.75).painted(_GLASS, Surface.GLASS)
    yield from wheels((-3.3, -2.2, 3.0), 1.0, 0.5, 0.3)
    yield from _lamps(3.98, -4.5, 0.9, 0.85)


def road_tanker(colour: Colour = (206, 208, 210), number: str = '33/1203') -> Mesh:
    """Return a semi-trailer tanker with its tractor, 15 m long."""
    cab = [(0.0, 0.6), (2.2, 0.6), (2.2, 1.7), (2.0, 3.1), (0.4, 3.3), (0.0, 3.0)]
    parts = [m.moved(4.0) for m in _chassis(cab, (30, 92, 60))]
    body = tank(1.18, 10.4, 0.35, 40).moved(-1.4, 0.0, 2.2).painted(colour, Surface.STEEL)
    parts += [
        body,
        box(10.0, 0.9, 0.3).moved(-1.4, 0.0, 0.95).painted((50, 50, 52), Surface.RUSTY),
    ]
    for x in (-4.8, -2.6, -0.4, 1.8):
        parts.append(upright(0.26, 0.16).moved(x, 0.0, 3.34).painted((90, 90, 92), Surface.STEEL))
    for side in (-1.0, 1.0):
        walk = box(8.4, 0.3, 0.05).moved(-1.4, side * 0.5, 3.24)
        parts.append(walk.painted((140, 140, 138), Surface.STEEL))
    parts.append(placard(number, 1.0).turned(yaw_deg=90.0).moved(-6.62, 0.0, 1.6))
    parts += wheels((-5.6, -4.3, -3.0), 1.0, 0.5, 0.34)
    return joined(parts)
