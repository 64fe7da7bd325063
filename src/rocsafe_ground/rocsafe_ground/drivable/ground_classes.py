# SPDX-License-Identifier: Apache-2.0
"""What kind of ground a photograph shows, from its colours.

Colours tell vegetation, bare soil, hard surfaces, water and what is none of them. They do not tell
a grey roof from a grey road: heights, labels and zones of an operator do.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray


class GroundClass(IntEnum):
    """Kinds of ground; the first three can be driven."""

    ROAD = 1
    GRASS = 2
    SOIL = 3
    VEGETATION = 4
    WATER = 5
    OBJECT = 6
    DARK = 7


@dataclass(frozen=True, slots=True, kw_only=True)
class ColourRules:
    """Limits of the classes; colours are 0 to 255.

    Set by eye on one mosaic, that of the scene `derailment`: temperate farmland under a clear
    sky. Excess green is that of Woebbecke et al. (1995).

    Attributes
    ----------
    dark
        What is less bright may be a shadow, a pit or a black thing: not driven.
    white
        What is brighter and has no colour is a painted or glazed thing.
    grey_saturation
        Hard surfaces have less saturation.
    object_saturation
        Painted things have more, vegetation aside.
    excess_green
        (2 g - r - b) / (r + g + b) of vegetation is above.
    grass_brightness
        Vegetation that is darker is high: hedges, crowns, shrubs.
    excess_blue
        (2 b - r - g) / (r + g + b) of water and of blue things is above.
    """

    dark: float = 42.0
    white: float = 225.0
    grey_saturation: float = 0.2
    object_saturation: float = 0.72
    excess_green: float = 0.06
    grass_brightness: float = 70.0
    excess_blue: float = 0.08


def ground_classes(
    red: FloatArray, green: FloatArray, blue: FloatArray, rules: ColourRules | None = None
) -> FloatArray:
    """Return the class of each colour, 0 where a colour is NaN; all arrays of one shape."""
    rules = rules or ColourRules()
    total = np.maximum(red + green + blue, 1.0)
    bright = np.maximum(np.maximum(red, green), blue)
    saturation = 1.0 - np.minimum(np.minimum(red, green), blue) / np.maximum(bright, 1.0)
    excess_green = (2.0 * green - red - blue) / total
    excess_blue = (2.0 * blue - red - green) / total
    is_grey = saturation < rules.grey_saturation
    is_warm = (red >= green) & (green >= blue) & (saturation <= rules.object_saturation)
    # The first that holds.
    cases: list[tuple[BoolArray, GroundClass]] = [
        (excess_blue > rules.excess_blue, GroundClass.WATER),
        (bright < rules.dark, GroundClass.DARK),
        (is_grey & (bright > rules.white), GroundClass.OBJECT),
        (is_grey, GroundClass.ROAD),
        (
            (excess_green > rules.excess_green) & (green < rules.grass_brightness),
            GroundClass.VEGETATION,
        ),
        ((green >= red) & (green > blue), GroundClass.GRASS),
        (is_warm & (excess_green > rules.excess_green), GroundClass.GRASS),
        (is_warm, GroundClass.SOIL),
    ]
    found = np.select(
        [case for case, _ in cases], [int(kind) for _, kind in cases], int(GroundClass.OBJECT)
    )
    return np.where(np.isnan(red), 0.0, found).astype(np.float64)
