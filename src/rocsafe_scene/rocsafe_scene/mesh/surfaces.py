# SPDX-License-Identifier: Apache-2.0
"""Kinds of surfaces and how they reflect light."""

from dataclasses import dataclass
from enum import IntEnum


class Surface(IntEnum):
    """Material of a vertex as drawn; its number is the fourth byte of the colour."""

    MATTE = 0
    PAINT = 1
    RUSTY = 2
    STEEL = 3
    GLASS = 4
    LEAF = 5
    BARK = 6
    CLOTH = 7
    STONE = 8
    TILE = 9
    RUBBER = 10
    LAMP = 11
    WATER = 12
    GRASS = 13
    WOOD = 14
    CROWN = 15


@dataclass(frozen=True, slots=True)
class Look:
    """How a surface reflects light.

    Attributes
    ----------
    gloss
        Strength of its mirror image of sun and sky, 0 to 1.
    sharpness
        Exponent of the sun's glint.
    grain
        How strongly dirt and wear vary its brightness, 0 to 1.
    through
        Share of the light that falls through from behind, 0 to 1.
    """

    gloss: float
    sharpness: float
    grain: float
    through: float = 0.0


LOOKS: dict[Surface, Look] = {
    Surface.MATTE: Look(0.03, 8.0, 0.35),
    Surface.PAINT: Look(0.22, 60.0, 0.28),
    Surface.RUSTY: Look(0.05, 12.0, 0.75),
    Surface.STEEL: Look(0.5, 40.0, 0.35),
    Surface.GLASS: Look(0.75, 200.0, 0.06),
    Surface.LEAF: Look(0.08, 14.0, 0.18, 0.45),
    Surface.BARK: Look(0.02, 6.0, 0.6),
    Surface.CLOTH: Look(0.02, 6.0, 0.2, 0.1),
    Surface.STONE: Look(0.03, 8.0, 0.55),
    Surface.TILE: Look(0.06, 14.0, 0.55),
    Surface.RUBBER: Look(0.05, 12.0, 0.3),
    Surface.LAMP: Look(0.3, 60.0, 0.0, 1.0),
    Surface.WATER: Look(0.9, 300.0, 0.1),
    Surface.GRASS: Look(0.04, 10.0, 0.15, 0.4),
    Surface.WOOD: Look(0.03, 8.0, 0.55),
    Surface.CROWN: Look(0.08, 14.0, 0.18, 0.45),
}
