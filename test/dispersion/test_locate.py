# SPDX-License-Identifier: Apache-2.0
"""Releases found from readings: places, rates, number, censored readings, bad input."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from rocsafe_dispersion.estimation.evidence import independent_share, plume_share
from rocsafe_dispersion.estimation.gas_survey import GasSurvey, averaged, point_survey
from rocsafe_dispersion.estimation.locate import locate_releases
from rocsafe_dispersion.estimation.plume_kernel import (
    PlumeShape,
    offset_weights,
    unit_readings,
)
from rocsafe_dispersion.estimation.release_options import LocateOptions, SearchArea
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume

from .airs import EASTWARDS, LAYER, SPEED_MPS

AREA = SearchArea(west_m=-50.0, south_m=-50.0, east_m=50.0, north_m=50.0, cell_m=5.0)
# Fewer shapes than by default: these tests ask what the shapes do not change.
QUICK = LocateOptions(
    spread_y=(1.0,), spread_z=(1.0,), turns_deg=(0.0,), fluctuations=((0.0, 0.4),)
)
TRAVEL = similarity_travel(LAYER, AREA.height_m)
NOISE_G_M3 = 2e-5


def places(step: float = 10.0) -> np.ndarray:
    """Return places of a lawn mower, 2 m above the ground."""
    axis = np.arange(-47.0, 48.0, step)
    east, north = np.meshgrid(axis, axis)
    return np.column_stack([east.ravel(), north.ravel(), np.full(east.size, 2.0)])


def readings(sources: list[tuple[float, float, float]], seed: int, background: float = 0.0):
    """Return a survey of sources (east, north, g/s), each reading scattered by 30 %."""
    generator = np.random.default_rng(seed)
    at = places()
    values = np.zeros(len(at))
    for east, north, rate in sources:
        release = Release(place_m=(east, north), height_m=AREA.height_m, rate_g_s=rate)
        plume = SteadyPlume(release=release, travel=TRAVEL, wind=EASTWARDS)
        values += plume.concentrations_g_m3(at)
    values = values * np.exp(0.3 * generator.standard_normal(len(at))) + background
    values = values + NOISE_G_M3 * generator.standard_normal(len(at))
    winds = np.tile((SPEED_MPS, 0.0), (len(at), 1))
    return point_survey(at, winds, values, np.full(len(at), NOISE_G_M3))


def test_kernel_is_the_plume():
    """The mean over the offsets of a meandering plume, within 1 %."""
    survey = readings([], 1)
    units = unit_readings(
        survey, np.array([[-20.0, 3.0]]), AREA.height_m, TRAVEL, SPEED_MPS, PlumeShape()
    )
    release = Release(place_m=(-20.0, 3.0), height_m=AREA.height_m, rate_g_s=1.0)
    plume = SteadyPlume(release=release, travel=TRAVEL, wind=EASTWARDS)
    expected = plume.concentrations_g_m3(places())
    found = np.einsum('o,on->n', offset_weights(units), units[:, :, 0])
    strong = expected > 0.05 * expected.max()
    # Five offsets stand for all.
    assert found[strong] == pytest.approx(expected[strong], rel=0.15)


@pytest.mark.parametrize('source', [(-22.0, 13.0, 2.0), (8.0, -28.0, 0.5)])
def test_one_release_is_found(source):
    """Within 8 m, the rate within a factor of 2, and the region holds it."""
    found = locate_releases(readings([source], 3), AREA, LAYER, options=QUICK)
    assert len(found.releases) == 1
    release = found.releases[0]
    assert math.dist(release.place_m, source[:2]) < 8.0
    assert 0.5 < release.rate_g_s / source[2] < 2.0
    assert release.rate_low_g_s < source[2] < release.rate_high_g_s
    assert release.holds(*source[:2])


@pytest.mark.slow
def test_two_releases_are_found():
    """Both, in one wind."""
    sources = [(-32.0, 22.0, 2.0), (-12.0, -18.0, 1.0)]
    found = locate_releases(readings(sources, 4), AREA, LAYER, options=QUICK)
    assert len(found.releases) == 2
    for release, source in zip(found.releases, sources, strict=True):
        assert math.dist(release.place_m, source[:2]) < 10.0


def test_few_clear_readings_are_a_release():
    """Two readings, 36 and 74 times the noise: clean air is no explanation."""
    survey = readings([(22.0, 13.0, 0.15)], 3)
    assert (survey.values_g_m3 > 5.0 * NOISE_G_M3).sum() == 2
    found = locate_releases(survey, AREA, LAYER, options=QUICK)
    assert len(found.releases) == 1
    assert found.releases[0].holds(22.0, 13.0)


@pytest.mark.slow
def test_a_zero_that_wanders_is_no_release():
    """By twice the noise, within ten readings: in 20 surveys none is found."""
    options = replace(QUICK, most_releases=1)
    for seed in range(20):
        clean = readings([], seed)
        white = np.random.default_rng(seed + 100).standard_normal(100)
        wandering = lfilter([math.sqrt(1.0 - 0.9**2)], [1.0, -0.9], white)
        values = clean.values_g_m3 + 2.0 * NOISE_G_M3 * wandering
        survey = replace(clean, values_g_m3=values)
        assert not locate_releases(survey, AREA, LAYER, options=options).releases


def test_share_of_independent_readings_is_that_of_a_process_of_first_order():
    """(1 - rho) / (1 + rho); readings of clean air count fully, and none for less than asked."""
    white = np.random.default_rng(1).standard_normal(5000)
    zero, noise = np.zeros(1), np.full(5000, 1.0)
    place, wind = np.zeros((5000, 3)), np.ones((5000, 2))
    for rho, least, expected in ((0.0, 0.3, 1.0), (0.5, 0.1, 1 / 3), (0.9, 0.3, 0.3)):
        values = lfilter([math.sqrt(1.0 - rho**2)], [1.0, -rho], white)
        share = independent_share(point_survey(place, wind, values, noise), zero, least)
        assert share == pytest.approx(expected, rel=0.1)
        # The order of the rows is not that of the times.
        order = np.random.default_rng(2).permutation(5000)
        mixed = point_survey(place, wind, values[order], noise, order.astype(float))
        assert independent_share(mixed, zero, least) == pytest.approx(share)


def test_readings_within_a_plume_tell_no_more_than_their_shared_error_allows():
    """The design effect of Kish: n independent readings are n / (1 + (n - 1) rho)."""
    for count, expected in ((0, 0.3), (1, 0.3), (11, 1 / 7), (41, 1 / 25)):
        values = np.where(np.arange(100) < count, 1.0, 0.0) + 1e-3
        survey = point_survey(np.zeros((100, 3)), np.ones((100, 2)), values, np.full(100, 1e-2))
        share = plume_share(survey, LocateOptions(), 1)
        assert share == pytest.approx(expected)
        assert share * count < 1.0 / 0.6 + 1.0
    # Two plumes of 20 or 21 readings each.
    assert plume_share(survey, LocateOptions(), 2) == pytest.approx(1 / 12.7)


def test_plumes_wider_and_higher_than_any_that_is_tried_first_are_found():
    """Sizes go on by the same factor where the readings ask for it; a rate needs its height."""
    options = replace(QUICK, spread_y=(0.35, 0.5), spread_z=(0.25, 0.35), most_releases=1)
    found = locate_releases(readings([(-22.0, 13.0, 2.0)], 3), AREA, LAYER, options=options)
    assert found.shape.spread_y > 0.6
    assert found.shape.spread_z > 0.45


def test_many_readings_within_a_plume_are_no_error():
    """The share of their information that counts is then below one in a hundred."""
    one = readings([(-22.0, 13.0, 2.0)], 3)
    survey = point_survey(
        np.tile(one.places_m[:, 0], (12, 1)),
        np.tile(one.wind_towards_mps, (12, 1)),
        np.tile(one.values_g_m3, 12),
        np.tile(one.std_g_m3, 12),
    )
    options = replace(QUICK, most_releases=1)
    assert len(locate_releases(survey, AREA, LAYER, options=options).releases) == 1


@pytest.mark.slow
def test_background_alone_is_no_release():
    """In 30 surveys of clean or evenly polluted air at most one is found."""
    options = replace(QUICK, most_releases=1)
    alarms = sum(
        bool(
            locate_releases(readings([], seed, background), AREA, LAYER, options=options).releases
        )
        for seed in range(15)
        for background in (0.0, 1e-3)
    )
    assert alarms <= 1


def test_background_is_told_from_the_release():
    """Its level comes back."""
    survey = readings([(-22.0, 13.0, 2.0)], 3, background=1e-3)
    found = locate_releases(survey, AREA, LAYER, options=QUICK)
    assert found.background_g_m3[0] == pytest.approx(1e-3, rel=0.1)
    assert math.dist(found.releases[0].place_m, (-22.0, 13.0)) < 8.0


@pytest.mark.slow
def test_censored_readings_tell_no_more_than_they_say():
    """What is below the limit or above the ceiling still leads to the release."""
    survey = readings([(-22.0, 13.0, 2.0)], 3)
    limit, ceiling = 2e-4, 5e-3
    values = np.clip(survey.values_g_m3, limit, ceiling)
    censored = replace(
        survey,
        values_g_m3=values,
        is_below=survey.values_g_m3 < limit,
        is_above=survey.values_g_m3 > ceiling,
    )
    found = locate_releases(censored, AREA, LAYER, options=QUICK)
    assert len(found.releases) == 1
    assert math.dist(found.releases[0].place_m, (-22.0, 13.0)) < 10.0


@pytest.mark.slow
def test_wrong_wind_direction_is_noticed():
    """Turned by 8 degrees: the turn is among those that are tried, and is found."""
    survey = readings([(-32.0, 3.0, 2.0)], 5)
    angle = math.radians(8.0)
    wrong = np.tile((SPEED_MPS * math.cos(angle), SPEED_MPS * math.sin(angle)), (100, 1))
    options = replace(QUICK, turns_deg=(-8.0, 0.0, 8.0))
    found = locate_releases(replace(survey, wind_towards_mps=wrong), AREA, LAYER, options=options)
    assert math.degrees(found.shape.turn_rad) == pytest.approx(-8.0)


def test_same_readings_same_answer():
    """Bit by bit."""
    survey = readings([(-22.0, 13.0, 2.0)], 3)
    first, second = (locate_releases(survey, AREA, LAYER, options=QUICK) for _ in range(2))
    assert first.releases[0].rate_g_s == second.releases[0].rate_g_s
    assert np.array_equal(first.releases[0].region_m, second.releases[0].region_m)


def survey_with(**changed) -> GasSurvey:
    """Return a survey with some values changed."""
    return replace(readings([], 1), **changed)


@pytest.mark.parametrize(
    'make',
    [
        lambda: survey_with(values_g_m3=np.full(100, np.nan)),
        lambda: survey_with(std_g_m3=np.zeros(100)),
        lambda: survey_with(times_s=np.zeros(3)),
        lambda: survey_with(instruments=np.full(100, -1)),
        lambda: point_survey(np.zeros((0, 3)), np.zeros((0, 2)), np.zeros(0), np.zeros(0)),
        lambda: locate_releases(survey_with(wind_towards_mps=np.zeros((100, 2))), AREA, LAYER),
        lambda: SearchArea(west_m=0.0, south_m=0.0, east_m=0.0, north_m=1.0),
        lambda: SearchArea(west_m=0.0, south_m=0.0, east_m=1e5, north_m=1e5),
        lambda: LocateOptions(information_share=2.0),
        lambda: LocateOptions(most_releases=7),
    ],
)
def test_bad_values_are_refused(make):
    """With one error type."""
    with pytest.raises(ValueError, match='must'):
        make()


def test_many_readings_are_averaged_where_they_were_taken():
    """Blocks of four: those that stand gain by the mean, of others the middle counts."""
    count = 400
    spots = np.zeros((count, 3))
    spots[200:, 0] = 10.0 * np.arange(200)
    below = np.arange(count) == 399
    values = np.arange(count, dtype=float)
    survey = point_survey(
        spots, np.tile([3.0, 0.0], (count, 1)), values, np.full(count, 2.0),
        is_below=below,
    )  # fmt: skip
    few = averaged(survey, 100)
    assert len(few.values_g_m3) == 101
    assert few.values_g_m3[:2].tolist() == [1.5, 5.5]
    assert few.std_g_m3[:2].tolist() == [1.0, 1.0]
    moving = np.flatnonzero(few.places_m[:, 0, 0] > 0.0)
    assert few.values_g_m3[moving].tolist() == (200.0 + few.places_m[moving, 0, 0] / 10.0).tolist()
    assert set(few.std_g_m3[moving]) == {2.0}
    assert few.is_below.sum() == 1
    assert averaged(survey, 400) is survey
