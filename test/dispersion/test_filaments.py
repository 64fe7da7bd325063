# SPDX-License-Identifier: Apache-2.0
"""Filaments: their mean is the plume, their mass is kept, a restart changes nothing."""

import numpy as np
import pytest

from rocsafe_dispersion.plume.filaments import FilamentCloud, FilamentOptions
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume

from .airs import EASTWARDS, LAYER, RELEASE, WIND

TRAVEL = similarity_travel(LAYER, 1.0)
PLACES = np.array([[x, 0.0, 1.5] for x in (50.0, 100.0, 200.0, 400.0)])


def readings(seed: int, times: np.ndarray) -> np.ndarray:
    """Return the concentrations at `PLACES`, (times, places)."""
    cloud = FilamentCloud(RELEASE, TRAVEL, WIND, seed)
    return np.array([cloud.at(time).concentrations_g_m3(PLACES) for time in times])


@pytest.mark.all
def test_mean_over_ten_minutes_is_the_plume():
    """Within 10 % on the axis, as the mean of three times ten minutes."""
    times = np.arange(200.0, 800.0, 0.6)
    means = np.mean([readings(seed, times).mean(axis=0) for seed in (1, 2, 3)], axis=0)
    plume = SteadyPlume(release=RELEASE, travel=TRAVEL, wind=EASTWARDS)
    assert means == pytest.approx(plume.concentrations_g_m3(PLACES), rel=0.1)


@pytest.mark.slow
def test_gas_comes_and_goes():
    """The largest reading is several times the mean, the least far below it."""
    found = readings(1, np.arange(200.0, 400.0, 0.5))
    ratio = found.max(axis=0) / found.mean(axis=0)
    assert (ratio > 2.0).all()
    assert (ratio < 20.0).all()
    assert (found.min(axis=0) < 0.2 * found.mean(axis=0)).all()


def test_mass_is_kept():
    """Without losses, to 1e-6."""
    release = Release(place_m=(0.0, 0.0), height_m=1.0, rate_g_s=3.0, duration_s=20.0)
    cloud = FilamentCloud(release, TRAVEL, WIND, 1)
    for time, mass in ((10.0, 30.0), (20.0, 60.0), (200.0, 60.0)):
        assert float(cloud.at(time).masses_g.sum(dtype=float)) == pytest.approx(mass, rel=1e-6)


@pytest.mark.slow
def test_restart_changes_nothing():
    """Nor do questions in between; another seed gives other filaments."""
    options = FilamentOptions(longest_s=60.0)
    old = FilamentCloud(RELEASE, TRAVEL, WIND, 5, options)
    for time in np.arange(0.0, 500.0, 7.3):
        old.at(time)
    fresh = FilamentCloud(RELEASE, TRAVEL, WIND, 5, options).at(500.0)
    other = FilamentCloud(RELEASE, TRAVEL, WIND, 6, options).at(500.0)
    assert np.allclose(old.at(500.0).middles_m, fresh.middles_m, rtol=0.0, atol=1e-3)
    assert not np.allclose(other.middles_m, fresh.middles_m, atol=0.5)


def test_before_the_start_there_is_nothing():
    """No filament, no concentration."""
    release = Release(place_m=(0.0, 0.0), height_m=1.0, rate_g_s=3.0, start_s=100.0)
    filaments = FilamentCloud(release, TRAVEL, WIND, 1).at(99.0)
    assert not len(filaments.masses_g)
    assert not filaments.concentrations_g_m3(PLACES).any()


@pytest.mark.parametrize('bad', [{'step_s': 0.0}, {'count': 0}, {'size_share': 2.0}])
def test_bad_options_are_refused(bad):
    """By the name of the option."""
    with pytest.raises(ValueError, match=next(iter(bad))):
        FilamentOptions(**bad)
