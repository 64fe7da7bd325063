# SPDX-License-Identifier: Apache-2.0
"""Whether another vehicle is in the way of a take-off."""

import math
from collections.abc import Iterable

from rocsafe_geo.position import distance_m
from rocsafe_mavlink.knowledge.telemetry import STALE_AFTER_S, Motion

ARMING_SHOWS_S = 3.0
"""A vehicle that was ordered to start its motors says within this time that they run."""


def in_the_way(
    start: Motion,
    others: Iterable[tuple[str, Motion | None]],
    separation_m: float,
    now_s: float,
) -> str:
    """Return which vehicle with running motors is too near to a place of take-off, in words.

    Parameters
    ----------
    start
        Where the vehicle is that is to take off.
    others
        Name of each other vehicle whose motors run, and where it is; None: not known.
    separation_m
        Least distance in space; 0: none is kept.
    now_s
        Steady time.

    Returns
    -------
    str
        Empty if none is.
    """
    if separation_m <= 0.0:
        return ''
    for name, there in others:
        if there is None:
            return f'{name} has running motors and tells no position'
        level_m = distance_m(start.position, there.position)
        away_m = math.hypot(level_m, there.altitude_msl_m - start.altitude_msl_m)
        if away_m < separation_m:
            old_s = now_s - there.heard_s
            when = f', last heard {old_s:.0f} s ago' if old_s > STALE_AFTER_S else ''
            words = f'{name} is {away_m:.0f} m away with running motors{when}'
            return f'{words}; {separation_m:g} m are wanted'
    return ''
