# SPDX-License-Identifier: Apache-2.0
"""Colours of dose rates on a logarithmic scale, distinct for the colour-blind.

Points of cividis (Nunez, Anderton and Renslow 2018), dark blue to yellow: the lightness rises
evenly for all kinds of colour vision and in print without colour.
"""

import math

LOWEST_USVH, HIGHEST_USVH = 0.1, 1e5
CIVIDIS = (
    (0, 32, 76), (0, 48, 110), (45, 65, 107), (76, 83, 108), (101, 101, 112), (124, 121, 120),
    (149, 141, 119), (176, 163, 113), (205, 186, 101), (234, 209, 82), (255, 234, 70),
)  # fmt: skip


def level_rgb(dose_rate_usvh: float) -> tuple[int, int, int]:
    """Return red, green and blue, 0 to 255, of a dose rate; beyond the scale, those at its end."""
    bounded = min(max(dose_rate_usvh, LOWEST_USVH), HIGHEST_USVH)
    share = math.log(bounded / LOWEST_USVH) / math.log(HIGHEST_USVH / LOWEST_USVH)
    place = share * (len(CIVIDIS) - 1)
    low = min(int(place), len(CIVIDIS) - 2)
    red, green, blue = (
        round(a + (b - a) * (place - low))
        for a, b in zip(CIVIDIS[low], CIVIDIS[low + 1], strict=True)
    )
    return red, green, blue
