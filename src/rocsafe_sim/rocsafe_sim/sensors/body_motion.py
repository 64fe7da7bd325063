# SPDX-License-Identifier: Apache-2.0
"""True motion of the body of a vehicle, as its sensors feel it."""

from collections.abc import Callable
from dataclasses import dataclass

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.state import Enu


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BodyState:
    """True state at one time.

    Attributes
    ----------
    time_ns
        Simulated time.
    position_enu, velocity_enu
        Metres and metres per second about the mission origin.
    rotation : (3, 3)
        From the body (forward, left, up) to east, north, up.
    """

    time_ns: int
    position_enu: Enu
    velocity_enu: Enu
    rotation: FloatArray


# The state at a time up to now.
StateAt = Callable[[int], BodyState]
