# SPDX-License-Identifier: Apache-2.0
"""Surface layer by Monin-Obukhov similarity: wind profile and turbulence."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between, require_positive

KARMAN = 0.4
# Below so many roughness lengths the profile is held constant: it has no meaning there.
LOWEST_LENGTHS = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SurfaceLayer:
    """The lowest tens of metres of the atmosphere.

    Attributes
    ----------
    friction_velocity_mps
        u*, m/s.
    obukhov_length_m
        Obukhov length L, metres: above 0 stable, below 0 unstable, infinite neutral.
    roughness_m
        Roughness length z0, metres: 0.006 mown grass, 0.03 meadow, 0.5 suburb, 1 town.
    mixing_height_m
        Depth of the mixed layer, metres; counts in unstable air only.
    """

    friction_velocity_mps: float
    obukhov_length_m: float = math.inf
    roughness_m: float = 0.03
    mixing_height_m: float = 1000.0

    def __post_init__(self) -> None:
        require_between('friction_velocity_mps', self.friction_velocity_mps, 1e-3, 10.0, 'm/s')
        require_between('roughness_m', self.roughness_m, 1e-5, 5.0, 'm')
        require_positive('mixing_height_m', self.mixing_height_m, 'm')
        if math.isnan(self.obukhov_length_m) or abs(self.obukhov_length_m) < 1.0:
            raise ValueError(
                f'obukhov_length_m is {self.obukhov_length_m:g}: must be at least 1 m from 0'
            )

    def speed_mps(self, height_m: ArrayLike) -> FloatArray:
        """Return the mean wind speed at heights above the ground, m/s, of their shape."""
        lowest = LOWEST_LENGTHS * self.roughness_m
        height = np.maximum(np.asarray(height_m, float), lowest)
        return self.friction_velocity_mps / KARMAN * _shape(self, height)

    def convective_velocity_mps(self) -> float:
        """Return w*, m/s; 0 unless the air is unstable."""
        if self.obukhov_length_m > 0.0:
            return 0.0
        ratio = self.mixing_height_m / (KARMAN * -self.obukhov_length_m)
        return float(self.friction_velocity_mps * np.cbrt(ratio))

    def sigma_v_mps(self) -> float:
        """Return the standard deviation of the crosswind component, m/s.

        sqrt((1.9 u*)^2 + 0.35 w*^2): mechanical part by Panofsky and Dutton 1984, convective
        part by Hicks 1985.
        """
        convective = self.convective_velocity_mps()
        return math.hypot(1.9 * self.friction_velocity_mps, math.sqrt(0.35) * convective)


def surface_layer(
    speed_mps: float,
    height_m: float,
    obukhov_length_m: float = math.inf,
    roughness_m: float = 0.03,
) -> SurfaceLayer:
    """Return the surface layer whose wind has a speed at a height above the ground.

    Raises
    ------
    ValueError
        If a value is out of range, or the height is within the roughness.
    """
    speed = require_positive('speed_mps', speed_mps, 'm/s')
    unit = SurfaceLayer(
        friction_velocity_mps=1.0, obukhov_length_m=obukhov_length_m, roughness_m=roughness_m
    )
    require_between('height_m', height_m, LOWEST_LENGTHS * roughness_m, 1000.0, 'm')
    friction = speed / float(unit.speed_mps(height_m))
    return SurfaceLayer(
        friction_velocity_mps=friction,
        obukhov_length_m=obukhov_length_m,
        roughness_m=roughness_m,
    )


def _shape(layer: SurfaceLayer, height_m: FloatArray) -> FloatArray:
    rough, length = layer.roughness_m, layer.obukhov_length_m
    correction = stability_correction(height_m / length) - stability_correction(rough / length)
    return np.asarray(np.log(height_m / rough) - correction)


def stability_correction(height_by_length: ArrayLike) -> FloatArray:
    """Return psi_m of z/L, of its shape.

    Stable: van Ulden and Holtslag 1985, equation 38; unstable: Paulson 1970.
    """
    ratio = np.asarray(height_by_length, float)
    stable = -17.0 * (1.0 - np.exp(-0.29 * np.maximum(ratio, 0.0)))
    x = (1.0 - 16.0 * np.minimum(ratio, 0.0)) ** 0.25
    unstable = (
        2.0 * np.log((1.0 + x) / 2.0)
        + np.log((1.0 + x * x) / 2.0)
        - 2.0 * np.arctan(x)
        + math.pi / 2.0
    )
    return np.where(ratio >= 0.0, stable, unstable)
