# SPDX-License-Identifier: Apache-2.0
"""Releases found from readings: places, rates, number, censored readings, bad input."""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest
from scipy.signal import lfilter

from rocsafe_dispersion.estimation.background_filter import BackgroundFilter
from rocsafe_dispersion.estimation.fluctuating_plume import PlumeReadings, Shapes
from rocsafe_dispersion.estimation.gas_survey import (
    BY_READING,
    GasSurvey,
    averaged,
    point_survey,
    usual_noise,
)
from rocsafe_dispersion.estimation.locate import locate_releases
from rocsafe_dispersion.estimation.placeless import gain_of_places
from rocsafe_dispersion.estimation.reading_density import cells, log_density
from rocsafe_dispersion.estimation.release_options import LocateOptions, SearchArea
from rocsafe_dispersion.estimation.release_sampler import (
    KIND,
    OWN,
    SHARED,
    Bounds,
    Kind,
    ReleaseSampler,
)
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_dispersion.plume.puffs import PuffCloud
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume

from .airs import EASTWARDS, LAYER, SPEED_MPS, WIND

AREA = SearchArea(west_m=-50.0, south_m=-50.0, east_m=50.0, north_m=50.0, cell_m=5.0)
ONE = LocateOptions(most_releases=1)
TRAVEL = similarity_travel(LAYER, AREA.height_m)
NOISE_G_M3 = 2e-5
STRONG = (-22.0, 13.0, 2.0)


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


def shapes(count: int, **changed: float) -> Shapes:
    """Return the shape that the air suggests, `count` times, with some values changed."""
    values = {
        'turn_rad': 0.0, 'spread_y': 1.0, 'spread_z': 1.0, 'meander': 0.0, 'relative': 0.0,
    } | changed  # fmt: skip
    return Shapes(**{name: np.full(count, value) for name, value in values.items()})


def test_mean_is_the_plume():
    """And without meander and eddies nothing comes and goes."""
    reader = PlumeReadings(readings([], 1), AREA.height_m, TRAVEL, SPEED_MPS)
    mean, spread = reader.of(np.array([[-20.0, 3.0]]), shapes(1))
    release = Release(place_m=(-20.0, 3.0), height_m=AREA.height_m, rate_g_s=1.0)
    plume = SteadyPlume(release=release, travel=TRAVEL, wind=EASTWARDS)
    assert mean[0] == pytest.approx(plume.concentrations_g_m3(places()), rel=1e-3, abs=1e-9)
    assert not spread.any()


@pytest.mark.parametrize('velocity', [(0.0, 1.0), (1.0, -0.5), (-1.5, 0.0)])
def test_plume_of_a_release_that_moves_is_that_of_its_puffs(velocity):
    """Gas is read where it was released, by the time that it took: within 15 % in the plume."""
    last_s = 40.0
    end = np.array([-10.0, 5.0])
    start = end - last_s * np.array(velocity)
    release = Release(
        place_m=tuple(start.tolist()), height_m=AREA.height_m, rate_g_s=1.0, start_s=-400.0,
        track=((400.0, *start.tolist()), (400.0 + last_s, *end.tolist())),
    )  # fmt: skip
    cloud = PuffCloud([(release, TRAVEL)], WIND, interval_s=0.1, longest_s=200.0)
    at = places(5.0)
    times = np.full(len(at), last_s)
    times[0] = 0.0
    survey = point_survey(
        at, np.tile((SPEED_MPS, 0.0), (len(at), 1)), np.zeros(len(at)), np.ones(len(at)), times
    )
    reader = PlumeReadings(survey, AREA.height_m, TRAVEL, SPEED_MPS)
    mean, _ = reader.of(end[None], shapes(1), ways_m=(end - start)[None])
    truth = cloud.at(last_s + 0.05).concentrations_g_m3(at)
    # Nearer than that, puffs spread against the wind, too.
    behind = at[:, 0] - end[0]
    seen = (truth > 0.2 * truth.max()) & (behind > 8.0)
    assert seen.sum() > 8
    assert mean[0][seen] == pytest.approx(truth[seen], rel=0.15)


def test_intensity_is_that_of_a_plume_that_moves_as_a_whole():
    """Against the mean square over drawn positions of its middle."""
    generator, meander = np.random.default_rng(1), 0.5
    middles = math.sqrt(meander) * generator.standard_normal((200_000, 2))
    reader = PlumeReadings(readings([], 1), AREA.height_m, TRAVEL, SPEED_MPS)
    mean, spread = reader.of(np.array([[-52.0, -11.0]]), shapes(1, meander=meander))
    for number in np.flatnonzero(mean[0] > 0.3 * mean[0].max())[:5]:
        east, north, height = places()[number]
        rows = TRAVEL.rows([east + 52.0])
        u, v = (
            offset / float(np.interp(rows[0], np.arange(len(column)), column))
            for offset, column in (
                (north + 11.0, TRAVEL.sigma_y_m), (height - AREA.height_m, TRAVEL.sigma_z_m)
            )
        )  # fmt: skip
        drawn = np.exp(-0.5 * ((middles - (u, v)) ** 2).sum(axis=1) / (1.0 - meander))
        intensity = drawn.std() / drawn.mean()
        assert spread[0, number] / mean[0, number] == pytest.approx(intensity, rel=0.02)


@pytest.mark.parametrize(('mean', 'intensity'), [(0.5, 1.0), (8.0, 0.5), (20.0, 2.0)])
def test_readings_of_the_table_are_those_that_are_drawn(mean, intensity):
    """Probabilities between bounds, of gas and noise drawn one by one."""
    generator = np.random.default_rng(1)
    gas = generator.gamma(intensity**-2, mean * intensity**2, 400_000)
    drawn = gas + generator.standard_t(4.0, gas.size)
    own = cells(np.array([mean]), np.array([intensity**2]))
    for bound in (-1.0, 0.5, mean, 2.0 * mean):
        below, above = (float(np.exp(log_density(np.array([bound]), own, k)[0])) for k in (1, 2))
        assert below + above == pytest.approx(1.0, abs=0.02)
        assert below == pytest.approx(float((drawn < bound).mean()), abs=0.02)
        near = float((np.abs(drawn - bound) < 0.05).mean()) / 0.1
        density = float(np.exp(log_density(np.array([bound]), own, 0)[0]))
        assert density == pytest.approx(near, rel=0.2, abs=1e-3)


@lru_cache
def found_of(source: tuple[float, float, float]):
    """Return what is found of one source, which several tests look at."""
    return locate_releases(readings([source], 3), AREA, LAYER, options=ONE)


@pytest.mark.slow
@pytest.mark.parametrize('source', [STRONG, (8.0, -28.0, 0.5)])
def test_one_release_is_found(source):
    """Within 8 m, the rate within a factor of 2, and region and interval hold it."""
    found = found_of(source)
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
    options = LocateOptions(most_releases=2)
    found = locate_releases(readings(sources, 4), AREA, LAYER, options=options)
    assert len(found.releases) == 2
    for release, source in zip(found.releases, sources, strict=True):
        assert math.dist(release.place_m, source[:2]) < 10.0


@pytest.mark.slow
def test_few_clear_readings_are_a_release():
    """Two readings, 36 and 74 times the noise: clean air is no explanation."""
    survey = readings([(22.0, 13.0, 0.15)], 3)
    assert (survey.values_g_m3 > 5.0 * NOISE_G_M3).sum() == 2
    found = locate_releases(survey, AREA, LAYER, options=ONE)
    assert len(found.releases) == 1
    assert found.releases[0].holds(22.0, 13.0)


@pytest.mark.slow
def test_a_zero_that_wanders_is_no_release():
    """By twice the noise, within ten readings: in 2 surveys none is found."""
    for seed in range(2):
        clean = readings([], seed)
        white = np.random.default_rng(seed + 100).standard_normal(100)
        wandering = lfilter([math.sqrt(1.0 - 0.9**2)], [1.0, -0.9], white)
        values = clean.values_g_m3 + 2.0 * NOISE_G_M3 * wandering
        survey = replace(clean, values_g_m3=values)
        assert not locate_releases(survey, AREA, LAYER, options=ONE).releases


def test_noise_that_is_not_told_is_that_of_clean_air():
    """Also of a sensor that shows no value below 0, and beside a plume; at least a share."""
    generator = np.random.default_rng(1)
    clean = generator.standard_normal(2000)
    assert usual_noise(clean) == pytest.approx(1.0, rel=0.1)
    assert 0.3 < usual_noise(np.maximum(clean, 0.0)) < 1.0
    assert usual_noise(np.where(np.arange(2000) % 10, clean, 300.0)) == pytest.approx(1.2, rel=0.2)
    assert usual_noise(np.array([0.0, 0.0, 0.0, 5.0])) == pytest.approx(0.005)
    # A value far below 0 stands for none.
    assert usual_noise(np.array([*clean, -999_999.0])) == pytest.approx(1.0, rel=0.1)
    assert usual_noise(np.full(8, -2.0)) == pytest.approx(0.002)


@pytest.mark.slow
def test_many_readings_within_a_plume_are_no_error():
    """The places that the gas reaches, four times each."""
    one = readings([STRONG], 3)
    often = np.where(one.values_g_m3 > 5.0 * NOISE_G_M3, 4, 1)
    survey = point_survey(
        np.repeat(one.places_m[:, 0], often, axis=0),
        np.repeat(one.wind_towards_mps, often, axis=0),
        np.repeat(one.values_g_m3, often),
        np.repeat(one.std_g_m3, often),
    )
    assert len(locate_releases(survey, AREA, LAYER, options=ONE).releases) == 1


@pytest.mark.slow
def test_background_alone_is_no_release():
    """In clean or evenly polluted air none is found."""
    for seed, background in ((0, 0.0), (1, 1e-3), (2, 1e-3)):
        survey = readings([], seed, background)
        assert not locate_releases(survey, AREA, LAYER, options=ONE).releases


@pytest.mark.slow
def test_background_is_told_from_the_release():
    """Its level comes back."""
    survey = readings([STRONG], 3, background=1e-3)
    found = locate_releases(survey, AREA, LAYER, options=ONE)
    assert found.background_g_m3[0] == pytest.approx(1e-3, rel=0.1)
    assert math.dist(found.releases[0].place_m, (-22.0, 13.0)) < 8.0


@pytest.mark.slow
def test_censored_readings_tell_no_more_than_they_say():
    """What is below the limit or above the ceiling still leads to the release."""
    survey = readings([STRONG], 3)
    limit, ceiling = 2e-4, 5e-3
    values = np.clip(survey.values_g_m3, limit, ceiling)
    censored = replace(
        survey,
        values_g_m3=values,
        is_below=survey.values_g_m3 < limit,
        is_above=survey.values_g_m3 > ceiling,
    )
    found = locate_releases(censored, AREA, LAYER, options=ONE)
    assert len(found.releases) == 1
    assert math.dist(found.releases[0].place_m, (-22.0, 13.0)) < 10.0


@pytest.mark.slow
def test_wrong_wind_direction_is_noticed():
    """Turned by 8 degrees: the turn is found within 3 degrees."""
    survey = readings([(-32.0, 3.0, 2.0)], 5)
    angle = math.radians(8.0)
    wrong = np.tile((SPEED_MPS * math.cos(angle), SPEED_MPS * math.sin(angle)), (100, 1))
    found = locate_releases(replace(survey, wind_towards_mps=wrong), AREA, LAYER, options=ONE)
    assert math.degrees(found.turn_rad) == pytest.approx(-8.0, abs=3.0)


@pytest.mark.slow
@pytest.mark.parametrize('turned_deg', [70.0, 180.0])
def test_wind_that_is_wrong_altogether_is_doubted(turned_deg):
    """The release is where it is all the same, the turn is told, and it is never enough."""
    survey, angle = readings([STRONG], 3), math.radians(turned_deg)
    wrong = np.tile((SPEED_MPS * math.cos(angle), SPEED_MPS * math.sin(angle)), (100, 1))
    found = locate_releases(replace(survey, wind_towards_mps=wrong), AREA, LAYER, options=ONE)
    assert found.wrong_wind > 0.9
    turn = math.degrees(found.turn_rad) + turned_deg
    assert (turn + 180.0) % 360.0 - 180.0 == pytest.approx(0.0, abs=15.0)
    assert found.releases[0].holds(-22.0, 13.0)
    verdict = ReleaseRule(region_m=1e3).verdict(found)
    assert not verdict.is_enough
    assert 'the direction of the wind is wrong with a probability of' in verdict.reason
    assert found_of(STRONG).wrong_wind < ReleaseRule().wrong_wind


@pytest.mark.slow
def test_a_release_beyond_the_ground_is_told_to_be_there():
    """30 m upwind of the edge: it was put on the ground, 49 m off."""
    found = locate_releases(readings([(-80.0, 5.0, 5.0)], 3), AREA, LAYER, options=ONE)
    (release,) = found.releases
    assert release.beyond > 0.5
    assert release.holds(-80.0, 5.0)
    assert math.dist(release.place_m, (-80.0, 5.0)) < 25.0
    verdict = ReleaseRule(region_m=1e3, hidden_share=0.9).verdict(found)
    assert not verdict.is_enough
    assert 'is outside of the ground searched' in verdict.reason
    assert verdict.reason.endswith('to the W: measure there')
    assert found_of(STRONG).releases[0].beyond < 0.1


@pytest.mark.slow
def test_readings_at_places_that_are_not_theirs_are_doubted():
    """Those of a release in another order: whatever is told of them, it is never enough."""
    survey = readings([STRONG], 3)
    loose = ReleaseRule(region_m=1e3, hidden_share=0.9)
    assert loose.verdict(found_of(STRONG)).is_enough
    order = np.random.default_rng(3).permutation(100)
    mixed = replace(survey, values_g_m3=survey.values_g_m3[order])
    found = locate_releases(mixed, AREA, LAYER, options=ONE)
    assert found.releases
    verdict = loose.verdict(found)
    assert not verdict.is_enough
    assert 'explained better without the places where they were taken' in verdict.reason


@pytest.mark.slow
def test_a_detector_that_steps_is_doubted():
    """Its levels have to do with the time and not with the place."""
    noise = np.random.default_rng(2).standard_normal(100)
    levels = np.repeat([0.0, 60.0, 0.0, 25.0, 90.0], 20)
    stepped = replace(readings([], 1), values_g_m3=NOISE_G_M3 * (levels + noise))
    found = locate_releases(stepped, AREA, LAYER, options=ONE)
    assert found.releases
    assert found.gain_of_places < 0.0
    verdict = ReleaseRule(region_m=1e3, hidden_share=0.9).verdict(found)
    assert not verdict.is_enough
    assert verdict.reason.startswith('1 release, placed within')
    assert 'doubted: the readings are explained better' in verdict.reason


def test_hypotheses_that_know_the_reading_gain_by_its_place():
    """Against those that know nothing; bounds that are alike tell nothing in either case."""
    survey = readings([STRONG], 3)
    scale = np.log(NOISE_G_M3)
    exact, ignorant = np.full((2, 100), -1.4 - scale), np.full((2, 100), -12.0 - scale)
    background = np.zeros(1)
    assert gain_of_places(survey, background, exact) > 0.0
    assert gain_of_places(survey, background, ignorant) < -100.0
    below = replace(survey, is_below=np.full(100, True), values_g_m3=np.full(100, 1e-4))
    assert gain_of_places(below, background, np.zeros((2, 100))) == pytest.approx(5.13, abs=0.1)


@pytest.mark.slow
@pytest.mark.parametrize('is_end', [False, True])
def test_release_that_starts_or_ends_among_the_readings(is_end):
    """It is told when, and readings of clean air before or after do not move its place."""
    # Flown twice: places of its plume are passed after 200 to 350 s, and after 700 to 850 s.
    flights = [readings([], 4), readings([STRONG], 3)][:: -1 if is_end else 1]
    both = {
        name: np.concatenate([getattr(flight, name) for flight in flights])
        for name in BY_READING
        if name != 'times_s'
    }
    twice = replace(flights[0], **both, times_s=np.arange(200.0) * 5.0, has_times=True)
    (release,) = locate_releases(twice, AREA, LAYER, options=ONE).releases
    moment, other = release.start, release.end
    if is_end:
        moment, other = other, moment
    assert moment.beyond < 0.05
    low_s, high_s = moment.bounds_s
    assert 200.0 < low_s < moment.time_s < high_s < 850.0
    assert other.bounds_s is None
    assert math.isnan(other.time_s)
    assert math.dist(release.place_m, STRONG[:2]) < 8.0
    assert found_of(STRONG).releases[0].start.beyond is None


@pytest.mark.slow
@pytest.mark.parametrize('way_m', [(0.0, 0.0), (25.0, -30.0)])
def test_release_that_moves_is_told_from_one_that_stands(way_m):
    """Flown over twice: its place is that of the last reading, and it is never enough."""
    empty = readings([], 4)
    both = {name: np.concatenate([getattr(empty, name)] * 2) for name in BY_READING}
    twice = replace(empty, **both | {'times_s': np.arange(200.0) * 4.0}, has_times=True)
    reader = PlumeReadings(twice, AREA.height_m, TRAVEL, SPEED_MPS)
    mean, _ = reader.of(np.array([STRONG[:2]]), shapes(1), ways_m=np.array([way_m]))
    scatter = np.exp(0.3 * np.random.default_rng(6).standard_normal(200))
    flown = replace(twice, values_g_m3=twice.values_g_m3 + STRONG[2] * mean[0] * scatter)
    found = locate_releases(flown, AREA, LAYER, options=ONE)
    (release,) = found.releases
    assert release.holds(*STRONG[:2])
    assert math.dist(release.place_m, STRONG[:2]) < 10.0
    if way_m == (0.0, 0.0):
        assert release.moves < 0.05
        assert release.velocity_mps is None
        return
    assert release.moves > 0.95
    assert release.velocity_mps == pytest.approx(np.array(way_m) / 796.0, abs=0.03)
    verdict = ReleaseRule(region_m=1000.0, hidden_share=0.9).verdict(found)
    assert not verdict.is_enough
    assert 'it moves with 0.05 m/s to the' in verdict.reason


@pytest.mark.slow
def test_same_readings_same_answer():
    """Bit by bit."""
    first, second = found_of(STRONG), found_of.__wrapped__(STRONG)
    assert first.releases[0].rate_g_s == second.releases[0].rate_g_s
    assert np.array_equal(first.releases[0].region_m, second.releases[0].region_m)


def test_hypotheses_far_out_have_turns_and_ways():
    """Moves of the sampler try them: nothing infinite stops a fit."""
    survey = replace(readings([STRONG], 3), has_times=True)
    reader = PlumeReadings(survey, AREA.height_m, TRAVEL, SPEED_MPS)
    bounds = Bounds(edges_m=(-50.0, -50.0, 50.0, 50.0), rates_g_s=(0.1, 10.0), times_s=(0.0, 99.0))
    generator = np.random.default_rng(1)
    sampler = ReleaseSampler(reader, BackgroundFilter(survey), bounds, ONE, generator)
    shared, own = np.full((2, SHARED), 40.0), np.full((2, OWN), 0.5)
    shared[1] *= -1.0
    shared[:, KIND] = Kind.MOVES
    shapes_m, ways_m = sampler.shapes_of(shared), sampler.ways_of(own, shared)
    assert np.isfinite(ways_m).all()
    mean, _ = reader.of(sampler.places_of(own), shapes_m, ways_m=ways_m)
    assert np.isfinite(mean).all()


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
        lambda: LocateOptions(particles=1),
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
