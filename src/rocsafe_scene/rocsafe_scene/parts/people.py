# SPDX-License-Identifier: Apache-2.0
"""People and animals: x ahead, z = 0 under their feet."""

import numpy as np

from rocsafe_scene.mesh.mesh import Colour, Mesh, joined
from rocsafe_scene.mesh.shapes import ball, box, tank, tube, upright
from rocsafe_scene.mesh.surfaces import Surface

_SKIN: Colour = (196, 150, 122)


def person(
    rng: np.random.Generator, coat: Colour = (214, 196, 40), hat: Colour = (240, 240, 236)
) -> Mesh:
    """Return somebody in a coloured coat and a helmet, 1.7 to 1.9 m tall, in mid-stride."""
    stride = float(rng.uniform(-0.22, 0.22))
    swing = float(rng.uniform(-0.25, 0.25))
    trousers: Colour = (40, 46, 66)
    parts = []
    for side, ahead in ((-1.0, stride), (1.0, -stride)):
        hip, foot = (0.0, side * 0.1, 0.92), (ahead, side * 0.12, 0.06)
        leg = tube([foot, (0.5 * ahead + 0.05, side * 0.11, 0.5), hip], [0.06, 0.075, 0.09], 8)
        parts.append(leg.painted(trousers, Surface.CLOTH))
        shoe = box(0.28, 0.11, 0.1, 0.03).moved(ahead + 0.05, side * 0.12)
        parts.append(shoe.painted((34, 30, 28), Surface.RUBBER))
        hand = (0.12 - side * swing, side * 0.3, 0.86)
        arm = tube(
            [(0.0, side * 0.2, 1.4), (0.02, side * 0.28, 1.12), hand], [0.07, 0.06, 0.05], 8
        )
        parts.append(arm.painted(coat, Surface.CLOTH))
        parts.append(ball(0.05, 8).moved(*hand).painted(_SKIN, Surface.CLOTH))
    torso = tank(0.2, 0.72, 0.14, 14).turned(pitch_deg=-90.0).scaled(0.72, 1.0, 1.0).moved(z=1.18)
    parts.append(torso.painted(coat, Surface.CLOTH))
    band = upright(0.206, 0.06, 14).scaled(0.72, 1.0, 1.0).moved(z=1.1)
    parts.append(band.painted((226, 226, 216), Surface.PAINT))
    parts.append(ball(0.115, 12).moved(z=1.64).painted(_SKIN, Surface.CLOTH))
    helmet = ball(0.145, 14).scaled(1.1, 1.0, 0.8).moved(z=1.7)
    parts.append(helmet.painted(hat, Surface.PAINT))
    height = float(rng.uniform(0.95, 1.06))
    return joined(parts).scaled(height, height, height)


def sheep(rng: np.random.Generator) -> Mesh:
    """Return a sheep, grazing or looking up."""
    wool: Colour = (214, 208, 192)
    body = tank(0.33, 1.05, 0.3, 14).scaled(1.0, 1.0, 0.95).moved(z=0.68)
    down = float(rng.uniform(0.25, 0.85))
    head = tank(0.11, 0.36, 0.12, 10).turned(pitch_deg=35.0).moved(0.66, 0.0, down)
    neck = tube([(0.4, 0.0, 0.78), (0.6, 0.0, down)], [0.16, 0.1], 8)
    parts = [
        body.painted(wool, Surface.CLOTH),
        neck.painted(wool, Surface.CLOTH),
        head.painted((50, 44, 42), Surface.CLOTH),
    ]
    for x in (-0.32, 0.32):
        for y in (-0.16, 0.16):
            leg = tube([(x, y, 0.0), (x, y, 0.5)], 0.05, 6)
            parts.append(leg.painted((58, 52, 48), Surface.CLOTH))
    return joined(parts)
