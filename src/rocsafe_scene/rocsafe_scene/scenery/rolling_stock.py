# SPDX-License-Identifier: Apache-2.0
"""Railway vehicles seen from above: tank cars, flat cars with flasks, box cars, a locomotive."""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from rocsafe_scene.scenery.light import brightness, shadow_of_box
from rocsafe_scene.scenery.marks import (
    Colour,
    Mark,
    Paint,
    Placing,
    disc,
    polygon,
    rectangle,
    stroke,
)
from rocsafe_scene.scenery.outlines import generator
from rocsafe_scene.scenery.scene import Thing

_STEEL = Paint((70, 68, 66), 40)
_FRAME = Paint((58, 46, 40), 60)
_GRATING = Paint((150, 150, 146), 70)
_BLACK = Paint((28, 28, 30), 20)
_GLASS = Paint((48, 60, 74), 10)
_WHITE = Paint((236, 236, 230), 15)
_YELLOW = Paint((236, 190, 28), 15)
_ORANGE = Paint((224, 108, 30), 20)
_DECK = Paint((124, 96, 72), 80)
_RUST = Paint((112, 62, 38), 60, 0.35)
_STRIPS = 13


def cylinder(
    placing: Placing, length_m: float, radius_m: float, paint: Paint, dish_m: float = 0.0
) -> Iterator[Mark]:
    """Yield a lying cylinder as strips, each lit as its part of the mantle faces the sun."""
    edges = np.linspace(-1.0, 1.0, _STRIPS + 1)
    cos, sin = math.cos(placing.yaw_rad), math.sin(placing.yaw_rad)
    for low, high in pairwise(edges.tolist()):
        middle = 0.5 * (low + high)
        side, up = middle, math.sqrt(1.0 - middle**2)
        light = brightness((-sin * side, cos * side, up))
        # A glint where the mantle looks half way between sun and camera.
        shine = 1.0 + 0.25 * math.exp(-(((light - 1.2) / 0.07) ** 2))
        half = 0.5 * length_m - dish_m * (1.0 - math.sqrt(1.0 - middle**2))
        corners = [
            [-half, low * radius_m],
            [half, low * radius_m],
            [half, high * radius_m],
            [-half, high * radius_m],
        ]
        yield polygon(placing.to_world(corners), paint.lit(light * shine * 0.95))


def tank_car(
    name: str, placing: Placing, colour: Colour, seed: int, *, is_on_its_side: bool = False
) -> Thing:
    """Return a four-axled tank car, 14.6 m long, upright or on its side."""
    rng = generator(seed, len(name), round(abs(placing.east_m) * 10))
    length, radius, height = 14.6, 1.52, 4.1 if not is_on_its_side else 3.1
    body: list[Mark] = list(_underframe(placing, length + 1.0, is_on_its_side))
    shift = 0.5 if is_on_its_side else 0.0
    barrel = placing.moved(0.0, shift)
    body += cylinder(barrel, length - 0.6, radius, Paint(colour, 25), dish_m=0.7)
    for x in np.linspace(-5.6, 5.6, 7).tolist():
        body.append(
            stroke(
                barrel.to_world([[x, -1.46], [x, 0.0], [x, 1.46]]),
                0.07,
                Paint((40, 40, 40), 10, 0.35),
            )
        )
    body += _streaks(barrel, length - 2.0, radius, rng)
    body += _tank_top(barrel, 0.0 if not is_on_its_side else 1.15)
    for end in (-1.0, 1.0):
        body.append(rectangle(barrel.moved(end * 4.6, 0.35 * end), 1.3, 0.75, _ORANGE))
    return Thing(
        name=name,
        kind='tank_car',
        placing=placing,
        size_m=(length, 3.0, height),
        colour=colour,
        shadow=(shadow_of_box(placing, length, 2.7, height),),
        body=tuple(body),
    )


def flask(name: str, placing: Placing, seed: int) -> Thing:
    """Return a transport flask for spent fuel: a finned cylinder between shock absorbers."""
    return Thing(
        name=name,
        kind='flask',
        placing=placing,
        size_m=(5.6, 2.5, 2.5),
        colour=(214, 216, 210),
        shadow=(shadow_of_box(placing, 5.4, 2.3, 2.4),),
        body=tuple(_flask_marks(placing, generator(seed, 5))),
    )


def flat_car(name: str, placing: Placing, flasks: tuple[float, ...], seed: int) -> Thing:
    """Return a flat car, 16 m long, with flasks at the given places along it."""
    rng = generator(seed, 6, len(name))
    body: list[Mark] = [rectangle(placing, 16.6, 1.0, _FRAME)]
    body += _bogies(placing, 5.6)
    body.append(rectangle(placing, 16.0, 2.75, _DECK))
    for x in np.arange(-7.8, 8.0, 0.42).tolist():
        plank = stroke(placing.to_world([[x, -1.36], [x, 1.36]]), 0.05, _BLACK.lit(1.4))
        body.append(plank)
    for y in (-1.3, 1.3):
        body.append(rectangle(placing.moved(0.0, y), 16.0, 0.14, _STEEL))
    for x in flasks:
        body += _flask_marks(placing.moved(x, 0.0), rng)
    height = 3.5 if flasks else 1.2
    return Thing(
        name=name,
        kind='flat_car',
        placing=placing,
        size_m=(16.0, 2.8, height),
        colour=(124, 96, 72),
        shadow=(
            shadow_of_box(placing, 16.0, 2.75, 1.2),
            *(shadow_of_box(placing.moved(x, 0.0), 5.2, 2.3, 3.5) for x in flasks),
        ),
        body=tuple(body),
    )


def box_car(name: str, placing: Placing, colour: Colour, seed: int) -> Thing:
    """Return a covered goods car, 12.6 m long, with a ribbed, rusty roof."""
    rng = generator(seed, 7, len(name), round(abs(placing.east_m) * 10))
    body: list[Mark] = [rectangle(placing, 13.6, 0.9, _FRAME)]
    body += cylinder(placing, 12.6, 1.42, Paint(colour, 45), dish_m=0.0)
    for x in np.linspace(-6.1, 6.1, 17).tolist():
        body.append(
            stroke(
                placing.to_world([[x, -1.4], [x, 0.0], [x, 1.4]]),
                0.09,
                Paint((20, 20, 20), 10, 0.3),
            )
        )
    body += _streaks(placing, 11.0, 1.4, rng)
    return Thing(
        name=name,
        kind='box_car',
        placing=placing,
        size_m=(12.6, 2.85, 3.9),
        colour=colour,
        shadow=(shadow_of_box(placing, 12.6, 2.8, 3.8),),
        body=tuple(body),
    )


def locomotive(name: str, placing: Placing) -> Thing:
    """Return a six-axled diesel locomotive, 20.8 m long, with a cab at each end."""
    hood = Paint((206, 98, 34), 30)
    body: list[Mark] = [rectangle(placing, 21.6, 1.0, _FRAME)]
    body.append(rectangle(placing, 20.6, 2.8, _STEEL))
    body += cylinder(placing, 20.4, 1.34, hood, dish_m=0.6)
    body.append(rectangle(placing, 12.6, 1.9, Paint((64, 64, 68), 60)))
    for end in (-1.0, 1.0):
        body.append(rectangle(placing.moved(end * 8.4, 0.0), 2.3, 2.3, _YELLOW.lit(0.95)))
        body.append(rectangle(placing.moved(end * 9.75, 0.0), 0.5, 2.3, _GLASS))
        body.append(rectangle(placing.moved(end * 10.3, 0.0), 0.25, 2.5, _BLACK))
    for x in (-4.4, -2.0, 3.6):
        body += [
            disc(placing.to_world([[x, 0.0]]), 0.85, _BLACK),
            disc(placing.to_world([[x, 0.0]]), 0.72, _STEEL.lit(1.3)),
            disc(placing.to_world([[x, 0.0]]), 0.2, _BLACK),
        ]
        body += [
            stroke(
                placing.to_world(
                    [
                        [x + 0.7 * math.cos(a), 0.7 * math.sin(a)],
                        [x - 0.7 * math.cos(a), -0.7 * math.sin(a)],
                    ]
                ),
                0.08,
                _BLACK,
            )
            for a in (0.2, 1.25, 2.3)
        ]
    for x in np.arange(0.0, 2.4, 0.3).tolist():
        body.append(stroke(placing.to_world([[x, -0.8], [x, 0.8]]), 0.1, _BLACK))
    body.append(rectangle(placing.moved(5.6, 0.0), 0.9, 0.5, _BLACK))
    return Thing(
        name=name,
        kind='locomotive',
        placing=placing,
        size_m=(20.6, 2.8, 4.0),
        colour=hood.colour,
        shadow=(shadow_of_box(placing, 20.6, 2.8, 4.0),),
        body=tuple(body),
    )


def _underframe(placing: Placing, length_m: float, is_on_its_side: bool) -> Iterator[Mark]:
    if not is_on_its_side:
        yield rectangle(placing, length_m, 2.2, _FRAME)
        yield from _bogies(placing, 4.7)
        return
    yield rectangle(placing.moved(0.0, -1.35), length_m, 1.1, _FRAME)
    for x in (-5.5, -3.7, 3.7, 5.5):
        for y in (-2.25, -1.1):
            wheel = placing.moved(x, y)
            yield disc(wheel.to_world([[0.0, 0.0]]), 0.46, _STEEL.lit(0.7))
            yield disc(wheel.to_world([[0.0, 0.0]]), 0.3, _STEEL.lit(1.5))
        yield stroke(placing.to_world([[x, -2.3], [x, -1.1]]), 0.2, _STEEL)


def _bogies(placing: Placing, at_m: float) -> Iterator[Mark]:
    for x in (-at_m, at_m):
        yield rectangle(placing.moved(x, 0.0), 2.8, 2.5, _FRAME.lit(0.75))


def _tank_top(placing: Placing, y: float) -> Iterator[Mark]:
    """Yield walkway, valves and manhole of a tank car."""
    yield rectangle(placing.moved(0.0, y), 6.4, 0.62, _GRATING)
    for x in np.arange(-3.1, 3.2, 0.31).tolist():
        yield stroke(placing.to_world([[x, y - 0.3], [x, y + 0.3]]), 0.05, _STEEL)
    for x, radius in ((0.0, 0.52), (1.5, 0.24), (-1.6, 0.24)):
        place = placing.to_world([[x, y]])
        yield disc(place, radius, _BLACK)
        yield disc(place, 0.82 * radius, _GRATING.lit(1.15))
        yield disc(place, 0.35 * radius, _STEEL)


def _streaks(
    placing: Placing, length_m: float, radius_m: float, rng: np.random.Generator
) -> Iterator[Mark]:
    """Yield rust and dirt that ran down the mantle."""
    for _ in range(16):
        x = rng.uniform(-0.5, 0.5) * length_m
        side = rng.choice([-1.0, 1.0])
        start, end = sorted(rng.uniform(0.15, 0.95, 2))
        line = [[x, side * start * radius_m], [x + rng.normal(0.0, 0.08), side * end * radius_m]]
        yield stroke(placing.to_world(line), rng.uniform(0.08, 0.3), _RUST)


def _flask_marks(placing: Placing, rng: np.random.Generator) -> Iterator[Mark]:
    white = Paint((214, 216, 210), 20)
    yield from cylinder(placing, 5.0, 1.05, white, dish_m=0.1)
    for x in np.arange(-1.55, 1.56, 0.31).tolist():
        yield stroke(
            placing.to_world([[x, -1.03], [x, 0.0], [x, 1.03]]),
            0.12,
            Paint((96, 100, 104), 10, 0.55),
        )
    for end in (-1.0, 1.0):
        yield from cylinder(placing.moved(end * 2.25, 0.0), 1.0, 1.2, Paint((196, 60, 44), 20))
    yield from trefoil(placing.moved(rng.uniform(-0.2, 0.2), 0.0), 0.78)


def trefoil(placing: Placing, radius_m: float) -> Iterator[Mark]:
    """Yield the radiation sign (ISO 361) on a yellow plate."""
    yield rectangle(placing, 2.5 * radius_m, 2.3 * radius_m, _YELLOW)
    for blade in (0.5, 0.5 + 2.0 * math.pi / 3.0, 0.5 + 4.0 * math.pi / 3.0):
        angles = np.linspace(blade, blade + math.pi / 3.0, 5)
        outer = radius_m * np.column_stack([np.cos(angles), np.sin(angles)])
        yield polygon(placing.to_world(np.vstack([outer, 0.3 * outer[::-1]])), _BLACK)
    yield disc(placing.to_world([[0.0, 0.0]]), 0.2 * radius_m, _BLACK)
