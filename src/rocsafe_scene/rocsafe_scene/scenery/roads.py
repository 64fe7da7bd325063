# SPDX-License-Identifier: Apache-2.0
"""Roads, tracks, water and what drives on the roads."""

import numpy as np

from rocsafe_scene.scenery.light import shadow_of_box
from rocsafe_scene.scenery.marks import (
    Colour,
    Coordinates,
    Mark,
    Paint,
    Placing,
    Points,
    disc,
    normals_of,
    rectangle,
    stroke,
)
from rocsafe_scene.scenery.outlines import blob, faded, generator, smooth_line
from rocsafe_scene.scenery.scene import Thing

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
_WINDOW = Paint((38, 44, 52), 10)
_TYRE = Paint((24, 24, 26), 20)
_BLUE_LIGHT = Paint((40, 96, 232), 5)
_WHITE = Paint((238, 238, 234), 10)


def road(name: str, points: Coordinates, width_m: float, seed: int) -> Thing:
    """Return an asphalt road with edge lines, a broken centre line and repairs."""
    line = smooth_line(points, 3.0)
    rng = generator(seed, 21, len(name))
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
    return _flat(name, 'road', line, ground)


def gravel_track(name: str, points: Coordinates, width_m: float, seed: int) -> Thing:
    """Return a gravel track with two ruts and grass creeping in."""
    line = smooth_line(points, 2.0)
    rng = generator(seed, 22, len(name))
    ground: list[Mark] = [
        stroke(line, width_m + 1.2, _VERGE),
        stroke(line + rng.normal(0.0, 0.12, line.shape), width_m, _GRAVEL),
    ]
    for side in (-0.85, 0.85):
        rut = _beside(line, side) + rng.normal(0.0, 0.06, line.shape)
        ground.append(stroke(rut, 0.55, _RUT))
    return _flat(name, 'track', line, ground)


def stream(name: str, points: Coordinates, width_m: float, seed: int) -> Thing:
    """Return a stream with banks and reeds."""
    line = smooth_line(points, 2.0)
    rng = generator(seed, 23, len(name))
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
    return _flat(name, 'stream', line, ground)


def car(name: str, placing: Placing, colour: Colour) -> Thing:
    """Return a car, 4.4 m long."""
    paint = Paint(colour, 10)
    body = [
        *_wheels(placing, 1.35, 0.82),
        rectangle(placing, 4.2, 1.74, paint.lit(0.9)),
        rectangle(placing, 3.9, 1.55, paint.lit(1.05)),
        rectangle(placing.moved(-0.25, 0.0), 2.5, 1.42, _WINDOW),
        rectangle(placing.moved(-0.3, 0.0), 1.5, 1.36, paint.lit(1.12)),
    ]
    return _vehicle(name, 'car', placing, (4.3, 1.8, 1.5), colour, body)


def fire_engine(name: str, placing: Placing) -> Thing:
    """Return a fire engine, 8.6 m long, hose reel and ladder on its roof."""
    red = Paint((198, 30, 28), 15)
    body = [
        *_wheels(placing, 2.6, 1.15),
        rectangle(placing, 8.6, 2.5, red.lit(0.9)),
        rectangle(placing.moved(-1.0, 0.0), 6.2, 2.2, red.lit(1.1)),
        rectangle(placing.moved(3.7, 0.0), 0.55, 2.2, _WINDOW),
        rectangle(placing.moved(2.75, 0.0), 0.45, 2.0, _BLUE_LIGHT),
        rectangle(placing.moved(-1.2, 0.55), 5.4, 0.5, Paint((176, 178, 180), 20)),
        rectangle(placing.moved(-1.2, -0.6), 4.0, 0.7, Paint((120, 122, 124), 30)),
        rectangle(placing.moved(-4.0, 0.0), 0.5, 2.3, Paint((236, 214, 40), 10)),
    ]
    for x in np.arange(-3.7, 1.4, 0.4).tolist():
        rung = placing.to_world([[x, 0.32], [x, 0.78]])
        body.append(stroke(rung, 0.08, Paint((90, 92, 94), 10)))
    return _vehicle(name, 'fire_engine', placing, (8.6, 2.5, 3.2), red.colour, body)


def ambulance(name: str, placing: Placing) -> Thing:
    """Return an ambulance, 6.4 m long, in yellow and green squares."""
    yellow, green = Paint((232, 222, 52), 10), Paint((28, 138, 72), 10)
    body = [
        *_wheels(placing, 1.9, 0.98),
        rectangle(placing, 6.4, 2.15, yellow),
        rectangle(placing.moved(-0.6, 0.0), 4.8, 1.7, _WHITE),
        rectangle(placing.moved(2.35, 0.0), 0.6, 1.85, _WINDOW),
        rectangle(placing.moved(1.5, 0.0), 0.35, 1.7, _BLUE_LIGHT),
    ]
    for number, x in enumerate(np.arange(-2.9, 1.6, 0.62).tolist()):
        side = 0.97 if number % 2 else -0.97
        body.append(rectangle(placing.moved(float(x), side), 0.6, 0.22, green))
    body += [
        rectangle(placing.moved(-0.8, 0.0), 1.3, 0.36, green),
        rectangle(placing.moved(-0.8, 0.0), 0.36, 1.3, green),
    ]
    return _vehicle(name, 'ambulance', placing, (6.4, 2.15, 2.7), yellow.colour, body)


def lorry(name: str, placing: Placing, colour: Colour) -> Thing:
    """Return a lorry, 10 m long."""
    paint = Paint(colour, 15)
    body = [
        *_wheels(placing, 3.4, 1.12),
        rectangle(placing.moved(3.9, 0.0), 2.2, 2.4, paint.lit(0.95)),
        rectangle(placing.moved(4.75, 0.0), 0.4, 2.1, _WINDOW),
        rectangle(placing.moved(-1.2, 0.0), 7.4, 2.5, Paint((206, 208, 208), 20)),
    ]
    for x in np.arange(-4.4, 2.3, 1.1).tolist():
        rib = placing.to_world([[x, -1.2], [x, 1.2]])
        body.append(stroke(rib, 0.08, Paint((168, 170, 172), 10)))
    return _vehicle(name, 'lorry', placing, (10.0, 2.5, 3.4), colour, body)


def people(name: str, centre: tuple[float, float], count: int, seed: int) -> Thing:
    """Return a group of people in protective suits."""
    rng = generator(seed, 25, count, int(centre[0]) & 0xFFFF)
    places = np.asarray(centre) + rng.normal(0.0, 1.7, (count, 2))
    suits = (Paint((236, 214, 40), 10), Paint((232, 234, 232), 10), Paint((240, 120, 30), 10))
    body: list[Mark] = []
    shadow: list[Mark] = []
    for place in places:
        east, north = place.tolist()
        placing = Placing(east, north, rng.uniform(0.0, 6.3))
        body.append(rectangle(placing, 0.3, 0.56, suits[int(rng.integers(3))]))
        body.append(disc(place, 0.13, Paint((60, 44, 36), 5)))
        shadow.append(shadow_of_box(placing, 0.3, 0.45, 1.7))
    return Thing(
        name=name,
        kind='people',
        placing=Placing(*centre),
        size_m=(0.6, 0.6, 0.0),
        shadow=tuple(shadow),
        body=tuple(body),
    )


def cordon(name: str, points: Coordinates) -> Thing:
    """Return a line of red and white tape."""
    line = smooth_line(points, 0.5)
    body: list[Mark] = []
    for at in range(0, len(line) - 2, 2):
        paint = Paint((214, 40, 36), 5) if at % 4 else _WHITE
        body.append(stroke(line[at : at + 3], 0.14, paint))
    shadow = tuple(disc(post, 0.12, Paint((0, 0, 0), 0)) for post in line[::12])
    middle = line[len(line) // 2]
    return Thing(
        name=name,
        kind='cordon',
        placing=Placing(float(middle[0]), float(middle[1])),
        size_m=(1.0, 1.0, 0.0),
        shadow=shadow,
        body=tuple(body),
    )


def puddles(name: str, points: Coordinates, paint: Paint, seed: int) -> Thing:
    """Return pools of a liquid that ran along points (n, 3): east, north, radius."""
    rng = generator(seed, 26, len(name))
    ground: list[Mark] = []
    for east, north, radius in np.asarray(points, float):
        outline = blob(rng, (east, north), (radius, 0.75 * radius), rng.uniform(0.0, 3.0))
        ground.append(faded(outline, paint, spread=0.3))
    first = np.asarray(points, float)[0]
    return Thing(
        name=name,
        kind='spill',
        placing=Placing(float(first[0]), float(first[1])),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(ground),
    )


def _wheels(placing: Placing, x_m: float, y_m: float) -> list[Mark]:
    return [
        rectangle(placing.moved(x, y), 0.7, 0.3, _TYRE) for x in (-x_m, x_m) for y in (-y_m, y_m)
    ]


def _vehicle(
    name: str,
    kind: str,
    placing: Placing,
    size_m: tuple[float, float, float],
    colour: Colour,
    body: list[Mark],
) -> Thing:
    length, width, height = size_m
    return Thing(
        name=name,
        kind=kind,
        placing=placing,
        size_m=size_m,
        colour=colour,
        shadow=(shadow_of_box(placing, length, width, height),),
        body=tuple(body),
    )


def _flat(name: str, kind: str, line: Points, ground: list[Mark]) -> Thing:
    middle = line[len(line) // 2]
    return Thing(
        name=name,
        kind=kind,
        placing=Placing(float(middle[0]), float(middle[1])),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(ground),
    )


def _beside(line: Points, offset_m: float) -> Points:
    return line + offset_m * normals_of(line)
