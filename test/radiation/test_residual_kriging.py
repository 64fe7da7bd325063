# SPDX-License-Identifier: Apache-2.0
"""The dose map follows what readings say beyond the estimate, and only that."""

import numpy as np
import pytest

from rocsafe_radiation.localization.localize import localize
from rocsafe_radiation.products.dose_map import dose_map
from rocsafe_radiation.products.residual_kriging import residual
from rocsafe_radiation.readings.survey import RadiationSurvey

from .simulated_survey import LOSSLESS, survey

AXIS = np.arange(0.0, 300.1, 10.0)


def uneven(seed=3):
    """Return a survey without a source over ground that varies by 30 % over 200 m."""
    flown = survey([])
    logs = log_ground(flown.positions_enu_m[:, 0], flown.positions_enu_m[:, 1])
    counts = np.random.default_rng(seed).poisson(550.0 * 0.1 * np.exp(logs))
    return RadiationSurvey(
        positions_enu_m=flown.positions_enu_m,
        counts=counts.astype(float),
        exposures=flown.exposures,
    )


def log_ground(east, north):
    """Return the logarithm of the background relative to its middle."""
    return 0.3 * np.sin(2.0 * np.pi * east / 200.0) * np.cos(2.0 * np.pi * north / 250.0)


def test_noise_is_not_kriged():
    """Readings that agree with the estimate leave it as it is, source or none."""
    for sources in ([], [(150.0, 120.0, 925.0)]):
        flown = survey(sources, seed=1)
        assert residual(localize(flown, LOSSLESS), flown, LOSSLESS.kernel, AXIS, AXIS) is None


def test_uneven_ground_is_followed_to_half_its_variation_or_better():
    """Without kriging, the map would miss all of it."""
    flown = uneven()
    found = localize(flown, LOSSLESS)
    assert not found.sources
    rest = residual(found, flown, LOSSLESS.kernel, AXIS, AXIS)
    truth = log_ground(*np.meshgrid(AXIS, AXIS))
    missed = rest.log_mean - rest.log_mean.mean() - (truth - truth.mean())
    assert missed.std() < 0.5 * truth.std()
    # What it says of its own error is right within a half.
    assert missed.std() == pytest.approx(rest.log_std.mean(), rel=0.5)


def test_beyond_the_readings_it_says_that_it_does_not_know():
    """Far away the residual is none, and as uncertain as the ground varies."""
    flown = uneven()
    far = np.array([5000.0, 5010.0])
    rest = residual(localize(flown, LOSSLESS), flown, LOSSLESS.kernel, far, far)
    assert np.abs(rest.log_mean).max() < 0.01
    assert 0.1 < rest.log_std.min() < 0.5


def test_the_map_has_the_residual_and_its_spread():
    """High where the ground is, with an upper bound above the mean."""
    flown = uneven()
    found = localize(flown, LOSSLESS)
    drawn = dose_map(found, flown, LOSSLESS.kernel, 2.5, largest_cells=10_000)
    column = round((50.0 - drawn.corner_m[0]) / drawn.cell_m)
    row = round((250.0 - drawn.corner_m[1]) / drawn.cell_m)
    low = round((125.0 - drawn.corner_m[1]) / drawn.cell_m)
    assert drawn.mean_usvh[row, column] > 1.3 * drawn.mean_usvh[low, column]
    assert (drawn.upper_usvh >= drawn.mean_usvh).all()
    assert drawn.std_usvh.min() > 0.0
