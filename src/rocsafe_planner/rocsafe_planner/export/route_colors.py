# SPDX-License-Identifier: Apache-2.0
"""Colours of routes on a map, distinguishable for colour-blind readers."""

# Okabe and Ito (2008), without black and the yellow that is lost on bright ground.
_HEX = ('#0072B2', '#E69F00', '#009E73', '#CC79A7', '#56B4E9', '#D55E00')

EXCLUSION_COLOR = '#AA0000'
"""Of zones that are not flown over."""


def route_color(index: int) -> str:
    """Return '#rrggbb' for the vehicle of that index; repeats after six."""
    return _HEX[index % len(_HEX)]


def kml_color(index: int) -> str:
    """Return the same colour in KML's order: opacity, blue, green, red as hexadecimal digits."""
    red, green, blue = (route_color(index)[i : i + 2] for i in (1, 3, 5))
    return f'ff{blue}{green}{red}'.lower()
