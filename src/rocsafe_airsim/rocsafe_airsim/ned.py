# SPDX-License-Identifier: Apache-2.0
"""North-east-down of AirSim, and east-north-up of ROS. A vehicle's origin is its home."""

import math
from dataclasses import dataclass

from rocsafe_geo.angle import wrap_rad

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""x, y, z, w."""

_HALF = math.sqrt(0.5)


def swapped(vector: Vector) -> Vector:
    """Return a vector of one frame in the other: each change is its own inverse."""
    x, y, z = vector
    return y, x, -z


def yaw_ned(yaw_enu_rad: float) -> float:
    """Return the yaw clockwise from north of a yaw anticlockwise from east, and back."""
    return wrap_rad(math.pi / 2.0 - yaw_enu_rad)


def attitude_ned(body_flu_in_enu: Quaternion) -> Quaternion:
    """Return the attitude of the body (forward, right, down) in NED.

    Parameters
    ----------
    body_flu_in_enu
        Attitude of the body (forward, left, up) in ENU.
    """
    x, y, z, w = product(product(_ENU_IN_NED, body_flu_in_enu), _FRD_IN_FLU)
    # Of the two that are the same attitude, the one that AirSim gives.
    return (x, y, z, w) if w >= 0.0 else (-x, -y, -z, -w)


def heading(yaw_enu_rad: float) -> Quaternion:
    """Return the attitude in NED of a level body of this yaw."""
    half = yaw_ned(yaw_enu_rad) / 2.0
    return 0.0, 0.0, math.sin(half), math.cos(half)


def yaw_of(attitude: Quaternion) -> float:
    """Return the yaw of an attitude, radians."""
    x, y, z, w = attitude
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@dataclass(frozen=True, slots=True)
class Origin:
    """The place of a vehicle's home in the mission's frame, metres, east, north, up."""

    home_enu: Vector

    def to_ned(self, place_enu: Vector) -> Vector:
        """Return a place about home, north, east, down."""
        a, b = place_enu, self.home_enu
        return swapped((a[0] - b[0], a[1] - b[1], a[2] - b[2]))

    def is_over(self, place_enu: Vector, nearest_m: float) -> bool:
        """Return whether a place is above or below home, to within a distance over ground."""
        return math.dist(self.home_enu[:2], place_enu[:2]) <= nearest_m

    def to_enu(self, place_ned: Vector) -> Vector:
        """Return a place in the mission's frame."""
        a, b = swapped(place_ned), self.home_enu
        return a[0] + b[0], a[1] + b[1], a[2] + b[2]


# Half a turn about the axis between x and y; half a turn about x.
_ENU_IN_NED: Quaternion = (_HALF, _HALF, 0.0, 0.0)
_FRD_IN_FLU: Quaternion = (1.0, 0.0, 0.0, 0.0)


def product(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the rotation by `b`, then by `a`."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )
