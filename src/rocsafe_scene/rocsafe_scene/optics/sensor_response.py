# SPDX-License-Identifier: Apache-2.0
"""Response of the sensor: sRGB curve, vignetting, noise."""

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import ImageArray
from rocsafe_scene.optics.distortion import Plane
from rocsafe_scene.optics.effects import Effects

Light = NDArray[np.float32]

_STEPS = 4096


def _linear(value: Plane) -> Plane:
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def _encoded(light: Plane) -> Plane:
    return np.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1.0 / 2.4) - 0.055)


_LIGHT_OF = _linear(np.arange(256) / 255.0).astype(np.float32)
# Indexed by the square root of the light, which gives dark tones enough steps.
_VALUE_OF = np.rint(255.0 * _encoded((np.arange(_STEPS + 1) / _STEPS) ** 2)).astype(np.uint8)


def light_of(image: ImageArray) -> Light:
    """Return the linear light of an image, 0 to 1, by the curve of sRGB (IEC 61966-2-1)."""
    return np.asarray(_LIGHT_OF[image])


def image_of_light(light: Light) -> ImageArray:
    """Return the image of linear light; values below 0 are black, above 1 white."""
    steps = np.rint(np.sqrt(np.clip(light, 0.0, 1.0)) * np.float32(_STEPS)).astype(np.uint16)
    return np.asarray(_VALUE_OF[steps])


def fall_off(x: Plane, y: Plane, share: float) -> Light:
    """Return the share of the light that reaches each pixel, 1 on the axis.

    Parameters
    ----------
    x, y
        Normalised image coordinates.
    share
        Share of natural vignetting, cos^4 of the angle from the axis; 0 to 1.
    """
    natural = 1.0 / (1.0 + x * x + y * y) ** 2
    return np.asarray(1.0 - share * (1.0 - natural), np.float32)


def with_noise(light: Light, effects: Effects, rng: np.random.Generator) -> Light:
    """Return `light` with photon noise and read noise.

    The electrons of a pixel are drawn from a normal distribution whose variance is their mean (as
    of a Poisson distribution) plus `read_noise_e` squared. A pixel is full at `full_well_e`.
    """
    well = np.float32(effects.full_well_e)
    electrons = np.minimum(light, 1.0) * well
    spread = np.sqrt(electrons + np.float32(effects.read_noise_e**2))
    electrons += spread * rng.standard_normal(light.shape, np.float32)
    return np.asarray(electrons / well)
