# SPDX-License-Identifier: Apache-2.0
"""Surveys over known sources, by formulas of their own."""

import numpy as np

from rocsafe_radiation.localization.localize import LocalizationOptions
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import RadiationSurvey

HEIGHT_M = 32.0
LOSSLESS = LocalizationOptions(kernel=Kernel(is_lossy=False), source_up_m=0.0, source_up_std_m=0.0)


def survey(sources, seed=0, sensitivity=550.0, background_usvh=0.1, position_noise_m=0.0):
    """Return counts of a lossless field on a 15 m grid of 300 x 300 m.

    `sources`: east, north, dose rate at 1 m in uSv/h.
    """
    generator = np.random.default_rng(seed)
    axis = np.arange(0.0, 300.1, 15.0)
    east, north = (part.ravel() for part in np.meshgrid(axis, axis))
    rates = np.full(east.size, background_usvh)
    for x, y, strength in sources:
        rates = rates + strength / ((east - x) ** 2 + (north - y) ** 2 + HEIGHT_M**2)
    places = np.stack([east, north, np.full(east.size, HEIGHT_M)], axis=1)
    places[:, :2] += generator.normal(0.0, position_noise_m, (east.size, 2))
    return RadiationSurvey(
        positions_enu_m=places,
        counts=generator.poisson(sensitivity * rates).astype(float),
        exposures=np.full(east.size, sensitivity),
    )
