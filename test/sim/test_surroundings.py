# SPDX-License-Identifier: Apache-2.0
"""Vehicles among hills and things: where they land, and what they fly into."""

import math
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test.scene.ray_scene import RayScene
from test.scene.scenes import PLANT, THINGS, small_environment
from test.sim.flights import AIRFRAME, HOME, ROUTE, START_NS, at_s, steps

from rocsafe_scene.solids.scene_surroundings import SceneSurroundings
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.fall import GRAVITY_MPS2
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.flight_record import FlightOutcome
from rocsafe_sim.vehicle.journal import read_journal, write_journal
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle


class Hillside:
    """Ground that rises by a tenth to the east, with a mast on it that is `mast_m` high."""

    def __init__(self, mast_m: float = 0.0, mast_at: tuple[float, float] = (12.0, 0.0)) -> None:
        self.mast_m, self.mast_at = mast_m, mast_at

    def ground_up_m(self, east_m, _north_m):
        """Return the height of the slope."""
        return 0.1 * east_m

    def touched(self, place_enu, radius_m):
        """Return whether the mast, a thin pole, is touched."""
        east, north, up = place_enu
        is_near = math.hypot(east - self.mast_at[0], north - self.mast_at[1]) < radius_m
        is_low = up < self.ground_up_m(*self.mast_at) + self.mast_m
        return 'mast' if is_near and is_low else ''


def flying(surroundings, route=ROUTE):
    """Return a vehicle at home among `surroundings` that has just been told to fly."""
    home = (*HOME[:2], surroundings.ground_up_m(*HOME[:2]))
    vehicle = SimulatedVehicle(AIRFRAME, home, surroundings)
    vehicle.step(START_NS)
    vehicle.fly_route(route)
    return vehicle


def test_it_takes_off_and_lands_on_the_ground_of_its_home():
    """Whatever the route says of that height."""
    vehicle = flying(Hillside())
    seen = list(steps(vehicle, 0.5))
    assert seen[0].pose.position_enu[2] == pytest.approx(-4.0, abs=0.2)
    assert seen[-1].pose.position_enu == pytest.approx((-40.0, 25.0, -4.0))
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.COMPLETED
    assert summary.viewpoints_visited == 4


def test_told_to_land_it_lands_on_the_ground_below():
    """Where it has come to a stop."""
    vehicle = flying(Hillside())
    next(seen for seen in steps(vehicle, 0.2) if seen.pose.position_enu[0] > 10.0)
    vehicle.land()
    *_, last = steps(vehicle, 0.2)
    east, _, up = last.pose.position_enu
    assert east > 10.0
    assert up == pytest.approx(0.1 * east)


def test_an_open_route_ends_on_the_ground_of_its_last_viewpoint():
    """Not at the height of home."""
    *_, last = steps(flying(Hillside(), replace(ROUTE, is_open=True)), 0.2)
    assert last.pose.position_enu == pytest.approx((0.0, 24.0, 0.0), abs=1e-6)


@pytest.mark.parametrize('step_s', [0.1, 0.77, 30.0])
def test_what_it_flies_into_ends_its_flight(step_s):
    """It falls to the ground below, says what it hit, and flies no more; no step changes that."""
    vehicle = flying(Hillside(mast_m=40.0))
    for _ in range(int(300.0 / step_s)):
        vehicle.step(vehicle.time_ns + round(step_s * 1e9))
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.COLLIDED
    assert summary.text == 'flew into mast after 1 viewpoints'
    assert vehicle.mode is Mode.CRASHED
    assert vehicle.is_idle
    place = vehicle.observe().pose.position_enu
    assert math.dist(place[:2], (12.0, 0.0)) < AIRFRAME.collision_radius_m
    assert place[2] == pytest.approx(0.1 * place[0])
    reference = flying(Hillside(mast_m=40.0))
    at_s(reference, 300.0)
    assert reference.summary() == summary
    assert reference.observe().pose == vehicle.observe().pose
    with pytest.raises(CommandRefusedError, match='cannot fly a route: flew into mast'):
        vehicle.fly_route(replace(ROUTE, plan_id='another'))


def test_it_falls_as_long_as_its_height_says():
    """From 32 m above the origin to the slope, without motors."""
    vehicle = flying(Hillside(mast_m=40.0))
    seen = list(next_until(vehicle, Mode.FALLING, Mode.CRASHED))
    falling = [each for each in seen if each.mode is Mode.FALLING]
    height_m = 32.0 - seen[-1].pose.position_enu[2]
    lasts_s = math.sqrt(2.0 * height_m / GRAVITY_MPS2)
    assert 0.02 * len(falling) == pytest.approx(lasts_s, abs=0.06)
    assert {each.power_w for each in falling} == {0.0}
    # a hold, a landing or the end of its goal do not stop a fall
    vehicle = flying(Hillside(mast_m=40.0))
    next(each for each in next_until(vehicle, Mode.FALLING))
    with pytest.raises(CommandRefusedError):
        vehicle.hold()
    vehicle.cancel()
    *_, last = next_until(vehicle, Mode.CRASHED)
    assert last.mode is Mode.CRASHED


def next_until(vehicle, *modes):
    """Yield what is observed every fiftieth of a second until the last of `modes` is reached."""
    for _ in range(40_000):
        seen = vehicle.step(vehicle.time_ns + 20_000_000)
        if seen.mode in modes:
            yield seen
        if seen.mode is modes[-1]:
            return
    raise AssertionError(f'never {modes[-1]}')


def test_a_hill_is_in_the_way_of_level_flight_only():
    """Too low a flight ends in the slope; taking off and landing on it do not."""
    low = replace(ROUTE, waypoints=(replace(ROUTE.waypoints[0], position_enu=(60.0, 0.0, 4.0)),))
    vehicle = flying(Hillside(), low)
    at_s(vehicle, 300.0)
    summary = vehicle.summary()
    assert summary is not None
    assert summary.text == 'flew into the ground after 0 viewpoints'
    assert vehicle.observe().pose.position_enu[0] == pytest.approx(36.0, abs=1.0)


def test_with_no_size_it_passes_through_everything():
    """The radius 0 switches collisions off."""
    vehicle = SimulatedVehicle(
        replace(AIRFRAME, collision_radius_m=0.0), HOME, Hillside(mast_m=40.0)
    )
    vehicle.step(START_NS)
    vehicle.fly_route(ROUTE)
    at_s(vehicle, 600.0)
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.COMPLETED


@pytest.mark.slow
@settings(max_examples=8)
@given(st.floats(1.0, 60.0))
def test_a_restart_changes_no_collision(restart_s):
    """Restored from its journal at any time, it hits the same at the same moment."""
    reference = flying(Hillside(mast_m=40.0))
    at_s(reference, 300.0)
    first = flying(Hillside(mast_m=40.0))
    at_s(first, restart_s)
    with TemporaryDirectory() as folder:
        write_journal(Path(folder) / 'journal.json', first.record)
        record = read_journal(Path(folder) / 'journal.json')
    assert record is not None
    second = SimulatedVehicle(AIRFRAME, HOME, Hillside(mast_m=40.0))
    second.restore(record)
    at_s(second, 300.0)
    assert second.summary() == reference.summary()
    assert second.record == reference.record


@pytest.mark.slow
def test_a_scene_is_met_as_its_rays_find_it():
    """Ground and touched things are those of the ray scene, for balls all over the place."""
    environment = small_environment(*THINGS, PLANT)
    rays, surroundings = RayScene(environment), SceneSurroundings(environment)
    rng = np.random.default_rng(8)
    places = np.column_stack([rng.uniform(-13.0, 13.0, (150, 2)), np.zeros(150)])
    grounds = environment.terrain.height_at(places[:, :2])
    places[:, 2] = grounds + rng.uniform(0.6, 5.0, 150)
    found = set()
    for place, ground in zip(places, grounds, strict=True):
        assert surroundings.ground_up_m(*place[:2].tolist()) == pytest.approx(ground)
        thing = surroundings.touched(tuple(place.tolist()), 0.5)
        assert thing == rays.touched(place, 0.5)
        found.add(thing)
    assert len(found) >= 4
    assert surroundings.touched((0.0, 0.0, 200.0), 0.5) == ''


@pytest.mark.slow
def test_a_beam_ends_where_the_rays_of_the_scene_do():
    """First hits are those of the ray scene: ground, things, and nothing, from above and aslant.

    Crossed within a step of 0.25 m, a ridge may be missed; a ray that grazes one is that rare.
    """
    environment = small_environment(*THINGS, PLANT)
    rays, surroundings = RayScene(environment), SceneSurroundings(environment)
    rng = np.random.default_rng(9)
    places = np.column_stack([rng.uniform(-13.0, 13.0, (150, 2)), rng.uniform(8.0, 20.0, 150)])
    ways = np.column_stack([rng.normal(0.0, 0.6, (150, 2)), -np.ones(150)])
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    truth = rays.first_hits(places, ways)
    assert len(set(truth.numbers.tolist())) >= 4
    for place, way, distance in zip(
        places.tolist(), ways.tolist(), truth.distances_m, strict=True
    ):
        found = surroundings.first_hit_m(tuple(place), tuple(way), 50.0)
        assert found == pytest.approx(distance, abs=1e-3)
    assert surroundings.first_hit_m((0.0, 0.0, 15.0), (0.0, 0.0, 1.0), 50.0) == math.inf
    assert surroundings.first_hit_m((0.0, 0.0, 190.0), (0.0, 0.0, -1.0), 50.0) == math.inf


def test_what_moves_is_not_in_the_way():
    """Only what stands is met."""
    path = ({'time_s': 0.0, 'at': (-10.0, 2.0)}, {'time_s': 10.0, 'at': (10.0, 2.0)})
    van = {'name': 'van', 'make': 'ambulance', 'at': (0.0, 0.0), 'path': path}
    surroundings = SceneSurroundings(small_environment(van))
    ground = surroundings.ground_up_m(-10.0, 2.0)
    assert surroundings.touched((-10.0, 2.0, ground + 1.0), 0.5) == ''
