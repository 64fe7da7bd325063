# SPDX-License-Identifier: Apache-2.0
"""Plumes and puffs: known answers, conservation of mass, losses, and bad input."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_dispersion.agents.agent_table import agent
from rocsafe_dispersion.plume.losses import Losses, settling_speed_mps
from rocsafe_dispersion.plume.puffs import PuffCloud, Puffs
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.rise import buoyancy_m4_s3, rise_m
from rocsafe_dispersion.plume.spread import briggs_travel, similarity_travel, vertical_shape
from rocsafe_dispersion.plume.steady_plume import SteadyPlume
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.similarity import SurfaceLayer, surface_layer
from rocsafe_geo.wind.wind_field import UniformWind
from rocsafe_geo.wind.wind_vector import WindVector, wind_from

from .airs import EASTWARDS, LAYER, RELEASE, WIND

AIRS = (
    LAYER,
    SurfaceLayer(friction_velocity_mps=0.25, obukhov_length_m=-15.0, roughness_m=0.1),
    SurfaceLayer(friction_velocity_mps=0.15, obukhov_length_m=20.0, roughness_m=0.01),
)


def flux_g_s(plume: SteadyPlume, layer: SurfaceLayer, distance_m: float) -> float:
    """Return what passes a plane across the wind, with the wind of each height."""
    row = int(plume.travel.rows(distance_m))
    sideways, upwards = plume.travel.sigma_y_m[row], plume.travel.sigma_z_m[row]
    y = np.linspace(-6.0, 6.0, 241) * sideways
    z = np.linspace(0.0, plume.release.height_m + 7.0 * upwards, 1200)
    places = np.stack(np.broadcast_arrays(distance_m, y[None], z[:, None]), axis=-1)
    found = plume.concentrations_g_m3(places.reshape(-1, 3)).reshape(len(z), len(y))
    return float(np.trapezoid(np.trapezoid(found, y, axis=1) * layer.speed_mps(z), z))


def plume_of(layer: SurfaceLayer, height_m: float = 1.0, **options) -> SteadyPlume:
    """Return the plume of 1 g/s."""
    release = Release(place_m=(0.0, 0.0), height_m=height_m, rate_g_s=1.0)
    travel = similarity_travel(layer, height_m, **options)
    return SteadyPlume(release=release, travel=travel, wind=EASTWARDS)


@pytest.mark.slow
@pytest.mark.parametrize('layer', AIRS)
@pytest.mark.parametrize('height', [0.0, 1.0, 8.0])
def test_what_is_released_passes_every_plane(layer: SurfaceLayer, height: float):
    """Within 0.5 %, with the real profile of the wind."""
    plume = plume_of(layer, height)
    for distance in (20.0, 100.0, 500.0, 2000.0):
        assert flux_g_s(plume, layer, distance) == pytest.approx(1.0, rel=5e-3)


def test_ccps_plume():
    """CCPS 1996, example 2.17 with curves of Briggs: 0.1 kg/s, class F, 2 m/s, 500 m downwind.

    The book has 1.03467e-4 kg/m^3 with its own curves; those of Briggs give
    Q / (pi sigma_y sigma_z u), here with sigma_y 19.518 and sigma_z 6.957 m.
    """
    layer = surface_layer(2.0, 10.0)
    release = Release(place_m=(0.0, 0.0), rate_g_s=100.0)
    travel = briggs_travel('F', layer, 0.0)
    plume = SteadyPlume(release=release, travel=travel, wind=EASTWARDS)
    found = float(plume.concentrations_g_m3(np.array([[500.0, 0.0, 0.0]]))[0])
    assert found == pytest.approx(100.0 / (math.pi * 19.518 * 6.957 * 2.0), rel=1e-3)


def test_plume_lies_downwind():
    """A wind from the west carries it to the east, one from the south to the north."""
    places = np.array([[100.0, 0.0, 1.0], [-100.0, 0.0, 1.0], [0.0, 100.0, 1.0]])
    travel = similarity_travel(LAYER, 1.0)
    for direction, downwind in ((270.0, 0), (180.0, 2)):
        plume = SteadyPlume(release=RELEASE, travel=travel, wind=wind_from(4.0, direction))
        assert int(plume.concentrations_g_m3(places).argmax()) == downwind


@pytest.mark.parametrize('losses', [Losses(), Losses(settling_mps=0.2)])
def test_one_place_has_the_concentration_of_many(losses: Losses):
    """Upwind, beside the release, far away; above gas and beneath particles that fall."""
    travel = similarity_travel(LAYER, 8.0, losses=losses)
    release = Release(place_m=(30.0, -20.0), height_m=8.0, rate_g_s=2.5)
    plume = SteadyPlume(release=release, travel=travel, wind=wind_from(4.0, 200.0))
    generator = np.random.default_rng(5)
    places = generator.normal(0.0, 1.0, (400, 3)) * 10.0 ** generator.uniform(-1, 4, (400, 1))
    places[:, 2] = generator.uniform(0.0, 20.0, 400)
    places[0] = 30.0, -20.0, 8.0
    found = [plume.concentration_g_m3(*place) for place in places.tolist()]
    assert found == pytest.approx(plume.concentrations_g_m3(places), rel=1e-9, abs=1e-300)
    assert sum(value > 1e-9 for value in found) > 15


def test_stable_air_keeps_a_plume_narrow():
    """At the same wind the concentration at the ground grows with stability."""
    place = np.array([[200.0, 0.0, 1.0]])
    airs = [surface_layer(3.0, 10.0, length, 0.03) for length in (-10.0, math.inf, 15.0)]
    found = [float(plume_of(air).concentrations_g_m3(place)[0]) for air in airs]
    assert found == sorted(found)
    assert found[2] > 5.0 * found[0]


def test_deposition_takes_what_the_ground_receives():
    """The loss of flow between two planes is the deposition velocity times what lies above."""
    losses = Losses(surface_resistance_s_m=30.0)
    plume = plume_of(LAYER, losses=losses)
    distances = np.linspace(50.0, 400.0, 701)
    y = np.linspace(-300.0, 300.0, 601)
    places = np.stack(np.broadcast_arrays(distances[:, None], y, 1.5), axis=-1).reshape(-1, 3)
    found = plume.concentrations_g_m3(places).reshape(len(distances), len(y))
    received = np.trapezoid(np.trapezoid(found, y, axis=1), distances)
    lost = flux_g_s(plume, LAYER, 50.0) - flux_g_s(plume, LAYER, 400.0)
    assert lost == pytest.approx(received * losses.deposition_mps(LAYER), rel=0.02)
    assert 0.05 < lost < 0.6


def test_decay_halves_after_its_half_life():
    """Over the time of travel."""
    half_life_s = 60.0
    travel = similarity_travel(LAYER, 1.0, losses=Losses(decay_per_s=math.log(2.0) / half_life_s))
    assert np.interp(half_life_s, travel.times_s, travel.airborne) == pytest.approx(0.5, rel=0.01)


def test_a_light_gas_rises_as_briggs_says():
    """Warm ammonia, worked by hand; in stable air less; chlorine does not; flux is conserved."""
    # 100 g/s of ammonia at 20 C: 0.1412 m^3/s, lighter by 0.412: F = 0.1817 m^4/s^3.
    flux = buoyancy_m4_s3(agent('ammonia'), 100.0, 20.0)
    assert flux == pytest.approx(0.1817, rel=0.002)
    assert buoyancy_m4_s3(agent('chlorine'), 100.0, 20.0) == 0.0
    assert buoyancy_m4_s3(agent('ammonia'), 100.0, 100.0) > 1.5 * flux
    neutral = surface_layer(3.0, 10.0)
    # The end at 49 F^(5/8) = 16.9 m: 1.6 F^(1/3) 16.9^(2/3) / 3 = 1.99 m.
    risen = rise_m(np.array([0.0, 5.0, 16.9, 500.0]), flux, neutral)
    assert risen == pytest.approx([0.0, 0.883, 1.99, 1.99], abs=0.01)
    stable = surface_layer(3.0, 10.0, 10.0)
    far = np.array([500.0])
    assert float(rise_m(far, 5.0, stable)[0]) < 0.85 * float(rise_m(far, 5.0, neutral)[0])
    plain, light = (similarity_travel(neutral, 1.0, buoyancy_m4_s3=each) for each in (0.0, flux))
    assert float(light.heights_m()[-1]) == pytest.approx(1.0 + 1.99, abs=0.01)
    heights = np.linspace(0.01, 60.0, 6000)
    row = int(np.searchsorted(light.distances_m, 30.0))
    shape = vertical_shape(heights, light.heights_m()[row], light.sigma_z_m[row])
    carried = np.sum(shape * neutral.speed_mps(heights)) * (heights[1] - heights[0])
    assert carried == pytest.approx(light.speeds_mps[row], rel=0.005)
    assert light.speeds_mps[row] > plain.speeds_mps[row]
    with pytest.raises(ValueError, match=r'height to which it rises .* must be'):
        similarity_travel(neutral, 1.0, buoyancy_m4_s3=50.0)


def test_particles_fall_at_known_speeds():
    """Unit density: 10 um 3.0 mm/s, 1 um 0.035 mm/s (Hinds 1999)."""
    assert settling_speed_mps(10e-6) == pytest.approx(3.06e-3, rel=0.02)
    assert settling_speed_mps(1e-6) == pytest.approx(3.5e-5, rel=0.03)


def test_heavy_particles_come_down():
    """The middle sinks by speed times time, and less stays in the air."""
    travel = similarity_travel(LAYER, 5.0, losses=Losses(settling_mps=0.05))
    row = int(travel.rows(100.0))
    assert travel.fallen_m[row] == pytest.approx(0.05 * travel.times_s[row], rel=1e-6)
    assert (np.diff(travel.airborne) <= 0.0).all()
    assert travel.airborne[int(travel.rows(2000.0))] < 0.9


def test_puffs_in_a_steady_wind_add_up_to_the_plume():
    """Within 2 % at 20 to 400 m, once they have passed."""
    travel = similarity_travel(LAYER, 1.0)
    plume = SteadyPlume(release=RELEASE, travel=travel, wind=EASTWARDS)
    places = np.array([[x, y, 1.5] for x in (20.0, 50.0, 150.0, 400.0) for y in (0.0, 3.0)])
    puffs = PuffCloud([(RELEASE, travel)], WIND, 0.5, 400.0).at(300.0)
    assert puffs.concentrations_g_m3(places) == pytest.approx(
        plume.concentrations_g_m3(places), rel=0.02
    )


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(st.floats(1.0, 500.0), st.sampled_from([0.7, 2.0, 5.0]), st.floats(0.5, 30.0))
def test_puffs_hold_what_was_released(time_s: float, interval_s: float, rate: float):
    """At every time, without losses: rate times the time of whole intervals."""
    release = Release(place_m=(3.0, 4.0), height_m=1.0, rate_g_s=rate, duration_s=100.0)
    cloud = PuffCloud([(release, similarity_travel(LAYER, 1.0))], WIND, interval_s, 1000.0)
    whole = math.floor(time_s / interval_s + 1e-9) * interval_s
    released = rate * min(whole, 100.0)
    assert cloud.at(time_s).masses_g.sum() == pytest.approx(released, rel=1e-6, abs=1e-9)


def test_burst_moves_with_the_wind_as_one_puff():
    """All its mass, in one place."""
    release = Release(place_m=(0.0, 0.0), height_m=1.0, burst_g=500.0, start_s=10.0)
    cloud = PuffCloud([(release, similarity_travel(LAYER, 1.0))], WIND, 1.0)
    assert not len(cloud.at(9.0).masses_g)
    puffs = cloud.at(60.0)
    assert puffs.masses_g == pytest.approx([500.0])
    assert 100.0 < puffs.middles_m[0, 0] < 300.0
    assert puffs.middles_m[0, 1] == pytest.approx(0.0)


def test_mass_of_a_puff_is_the_integral_of_its_concentration():
    """Over all space above the ground."""
    puffs = Puffs(
        middles_m=np.array([[0.0, 0.0, 2.0]]),
        sigma_m=np.array([[5.0, 3.0]]),
        masses_g=np.array([7.0]),
    )
    axis = np.linspace(-30.0, 30.0, 61)
    levels = np.linspace(0.0, 25.0, 201)
    sums = [puffs.on_grid_g_m3(axis, axis, level).sum() for level in levels]
    assert np.trapezoid(sums, levels) == pytest.approx(7.0, rel=1e-3)


def test_grid_and_places_give_the_same():
    """The product of matrices and the sum over puffs."""
    cloud = PuffCloud([(RELEASE, similarity_travel(LAYER, 1.0))], WIND, 5.0, 300.0)
    puffs = cloud.at(100.0)
    east, north = np.linspace(0.0, 200.0, 7), np.linspace(-20.0, 20.0, 5)
    grid = puffs.on_grid_g_m3(east, north, 2.0)
    places = np.array([[e, n, 2.0] for n in north for e in east])
    assert grid.ravel() == pytest.approx(puffs.concentrations_g_m3(places), rel=1e-9)


def test_restart_changes_nothing():
    """A fresh cloud has the same puffs as one that has run since the start."""
    travel = similarity_travel(LAYER, 1.0)
    old = PuffCloud([(RELEASE, travel)], WIND, 2.0, 100.0)
    for time in (10.0, 333.0, 690.0):
        old.at(time)
    first, second = old.at(700.0), PuffCloud([(RELEASE, travel)], WIND, 2.0, 100.0).at(700.0)
    assert np.allclose(first.middles_m, second.middles_m, rtol=0.0, atol=1e-9)
    assert np.array_equal(first.masses_g, second.masses_g)
    assert len(first.masses_g) == 50


def test_puffs_follow_a_wind_that_turns():
    """Old ones lie where the old wind carried them."""

    class Turning:
        def velocities_mps(self, time_s: float, places_m: FloatArray) -> FloatArray:
            towards = (3.0, 0.0, 0.0) if time_s < 50.0 else (0.0, 3.0, 0.0)
            return np.tile(towards, (len(places_m), 1))

    cloud = PuffCloud([(RELEASE, similarity_travel(LAYER, 1.0))], Turning(), 1.0)
    middles = cloud.at(100.0).middles_m
    assert middles[0, :2] == pytest.approx([148.5, 150.0], abs=2.0)
    assert middles[-1, :2] == pytest.approx([0.0, 1.5], abs=0.5)


def test_moving_release_leaves_puffs_along_its_track():
    """In still air they stay where they left."""
    release = Release(place_m=(0.0, 0.0), rate_g_s=1.0, track=((100.0, 50.0, 20.0),))
    still = UniformWind(wind=WindVector(towards_east_mps=0.0, towards_north_mps=0.0))
    cloud = PuffCloud([(release, similarity_travel(LAYER, 0.0))], still, 1.0)
    middles = cloud.at(100.0).middles_m
    assert np.allclose(middles[:, 0], np.arange(0.25, 50.0, 0.5))
    assert np.allclose(middles[:, 1], 0.4 * middles[:, 0])


@pytest.mark.parametrize(
    'make',
    [
        lambda: Release(place_m=(0.0, 0.0)),
        lambda: Release(place_m=(0.0, 0.0), rate_g_s=1.0, burst_g=1.0),
        lambda: Release(place_m=(math.nan, 0.0), rate_g_s=1.0),
        lambda: Release(place_m=(0.0, 0.0), rate_g_s=-1.0),
        lambda: Release(place_m=(0.0, 0.0), rate_g_s=1.0, duration_s=0.0),
        lambda: Release(place_m=(0.0, 0.0), rate_g_s=1.0, track=((5.0, 0, 0), (4.0, 0, 0))),
        lambda: similarity_travel(LAYER, 100.0),
        lambda: similarity_travel(LAYER, 1.0, sigma_theta_rad=math.nan),
        lambda: Losses(surface_resistance_s_m=-1.0),
        lambda: settling_speed_mps(1e-3),
        lambda: SteadyPlume(
            release=RELEASE,
            travel=similarity_travel(LAYER, 1.0),
            wind=WindVector(towards_east_mps=0.0, towards_north_mps=0.0),
        ),
        lambda: SteadyPlume(
            release=Release(place_m=(0.0, 0.0), burst_g=1.0),
            travel=similarity_travel(LAYER, 1.0),
            wind=EASTWARDS,
        ),
    ],
)
def test_bad_values_are_refused(make):
    """With one error type."""
    with pytest.raises(ValueError, match=r'must|needs'):
        make()
