# SPDX-License-Identifier: Apache-2.0
"""Lengths of scale bars of maps."""

import math


def bar_length_m(most_m: float) -> float:
    """Return the longest of 1, 2 or 5 times a power of ten, metres, that is not above `most_m`."""
    power = 10.0 ** math.floor(math.log10(most_m))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= most_m * (1.0 + 1e-9))
