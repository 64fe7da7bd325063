# SPDX-License-Identifier: Apache-2.0
"""The interface of all winds, and the steady winds: uniform and profile."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_positive
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.wind_vector import WindVector


class WindField(Protocol):
    """Velocity of the air anywhere at any time; a pure function, the same after a restart."""

    def velocities_mps(self, time_s: float, places_m: FloatArray) -> FloatArray:
        """Return the velocity of the air, towards east, north and up, (n, 3), m/s.

        Parameters
        ----------
        time_s
            Seconds since the start of the mission; may be negative.
        places_m : (n, 3)
            East and north of the origin and height above the ground, metres.
        """
        ...


@dataclass(frozen=True, slots=True, kw_only=True)
class UniformWind:
    """The same wind everywhere and always."""

    wind: WindVector

    def velocities_mps(self, time_s: float, places_m: FloatArray) -> FloatArray:  # noqa: ARG002
        """Return the velocity of the air, see `WindField`."""
        return towards(self.wind, np.ones(len(places_m)))


@dataclass(frozen=True, slots=True, kw_only=True)
class ProfileWind:
    """A steady wind that grows with the height above the ground.

    Attributes
    ----------
    layer
        Its profile.
    wind
        Its direction, and its speed at `reference_height_m`.
    reference_height_m
        Height above the ground of `wind`, metres.
    """

    layer: SurfaceLayer
    wind: WindVector
    reference_height_m: float = 10.0

    def __post_init__(self) -> None:
        require_positive('reference_height_m', self.reference_height_m, 'm')

    def velocities_mps(self, time_s: float, places_m: FloatArray) -> FloatArray:  # noqa: ARG002
        """Return the velocity of the air, see `WindField`."""
        reference = float(self.layer.speed_mps(self.reference_height_m))
        return towards(self.wind, self.layer.speed_mps(places_m[:, 2]) / reference)


def towards(wind: WindVector, shares: FloatArray) -> FloatArray:
    """Return `wind` times each of `shares` (n,) as velocities (n, 3), m/s."""
    velocity = np.array([wind.towards_east_mps, wind.towards_north_mps, 0.0])
    return np.asarray(shares[:, None] * velocity)
