# SPDX-License-Identifier: Apache-2.0
"""Headings and yaws, in radians.

A heading turns clockwise from north (compass). A yaw turns anticlockwise from east (REP 103).
Every function takes a float or an array and returns the same kind.
"""

import math
from typing import TypeVar

from rocsafe_geo.arrays import FloatArray

Angle = TypeVar('Angle', float, FloatArray)


def wrap_rad(angle_rad: Angle) -> Angle:
    """Return the same direction within (-pi, pi]."""
    # The second modulo turns a remainder that rounding made a full turn into zero.
    return math.pi - (math.pi - angle_rad) % math.tau % math.tau


def yaw_of_heading_rad(heading_rad: Angle) -> Angle:
    """Return the yaw, within (-pi, pi], of a compass heading."""
    return wrap_rad(math.pi / 2.0 - heading_rad)


def heading_of_yaw_rad(yaw_rad: Angle) -> Angle:
    """Return the compass heading, within [0, 2 pi), of a yaw."""
    return (math.pi / 2.0 - yaw_rad) % math.tau % math.tau
