# SPDX-License-Identifier: Apache-2.0
"""A simulated vehicle that flies freely: take-off, places, velocities, turns."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from test.sim.flights import AIRFRAME, HOME, START_NS, at_s, vehicle_on

from rocsafe_geo.angle import wrap_rad
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.fence import Fence
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.free_vehicle import FreeVehicle
from rocsafe_sim.vehicle.journal import read_journal, write_journal

UP = (HOME[0], HOME[1], 10.0)
PLACES = ((0.0, 0.0, 20.0), (30.0, 0.0, 20.0), (30.0, 40.0, 12.0))


def in_the_air(**options) -> FreeVehicle:
    """Return a vehicle that has taken off to 10 m and stands there."""
    vehicle = FreeVehicle(replace(AIRFRAME, **options), HOME)
    vehicle.step(START_NS)
    vehicle.fly_along([UP])
    at_s(vehicle, 30.0)
    assert (vehicle.mode, vehicle.pose_at(vehicle.time_ns).position_enu) == (Mode.HOLDING, UP)
    return vehicle


def later(vehicle: FreeVehicle, seconds: float):
    """Return the state some seconds later."""
    return vehicle.step(vehicle.time_ns + round(seconds * NS_PER_S))


def test_takes_off_flies_along_places_and_stays() -> None:
    """Each place is passed, the take-off is one, and landing ends the flight."""
    vehicle = FreeVehicle(AIRFRAME, HOME)
    vehicle.step(START_NS)
    vehicle.fly_along(PLACES, 5.0)
    seen = [at_s(vehicle, second / 4) for second in range(400)]
    assert {one.mode for one in seen} == {Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING}
    for place in PLACES:
        nearest = min(math.dist(one.pose.position_enu, place) for one in seen)
        assert nearest < 0.7
    assert seen[-1].pose.position_enu == PLACES[-1]
    assert max(one.pose.speed_mps for one in seen) == pytest.approx(5.0, abs=0.01)
    vehicle.land()
    last = at_s(vehicle, 140.0)
    assert last.mode is Mode.LANDED
    assert vehicle.is_idle
    vehicle.fly_along([(30.0, 40.0, 5.0)])
    assert at_s(vehicle, 160.0).mode is Mode.HOLDING


def test_a_velocity_is_flown_and_ends_in_a_stand() -> None:
    """Two orders one after the other do not stop between."""
    vehicle = in_the_air()
    vehicle.fly_at((4.0, 0.0, 0.5), 5.0, turn_rate_radps=0.3)
    seen = later(vehicle, 4.0)
    assert seen.mode is Mode.FLYING
    assert seen.pose.velocity_enu == pytest.approx((4.0, 0.0, 0.5))
    vehicle.fly_at((0.0, 4.0, 0.0), 5.0)
    slowest = min(later(vehicle, 0.1).pose.speed_mps for _ in range(45))
    assert slowest > 2.5
    end = later(vehicle, 10.0)
    assert end.mode is Mode.HOLDING
    assert end.pose.motion.is_still
    assert end.pose.yaw_rad == pytest.approx(0.3 * 4.0)


def test_it_turns_at_a_rate_as_long_as_it_flies() -> None:
    """More than a whole turn in one order, and none in the stop after it."""
    vehicle = in_the_air()
    vehicle.fly_at((6.0, 0.0, 0.0), 10.0, turn_rate_radps=0.8)
    for second in range(1, 11):
        seen = later(vehicle, 1.0)
        assert wrap_rad(seen.pose.yaw_rad - 0.8 * second) == pytest.approx(0.0, abs=1e-9)
    end = later(vehicle, 10.0)
    assert end.pose.motion.is_still
    assert wrap_rad(end.pose.yaw_rad - 8.0) == pytest.approx(0.0, abs=1e-9)


def test_it_turns_to_a_yaw_while_it_flies() -> None:
    """At the rate of its turns, the shorter way; then the yaw stays."""
    vehicle = in_the_air()
    vehicle.fly_at((3.0, 0.0, 0.0), 8.0, yaw_rad=-math.pi / 2)
    assert later(vehicle, 1.0).pose.yaw_rad == pytest.approx(-math.pi / 4)
    assert later(vehicle, 1.5).pose.yaw_rad == pytest.approx(-math.pi / 2)
    assert later(vehicle, 15.0).pose.yaw_rad == pytest.approx(-math.pi / 2)


def test_a_wind_that_changes_costs_charge_and_leaves_the_goal() -> None:
    """A headwind empties the battery more; the way goes on to the same place."""
    charges = []
    for wind in ((0.0, 0.0), (-6.0, 0.0)):
        vehicle = in_the_air()
        vehicle.fly_along([(120.0, 0.0, 20.0)], 6.0)
        later(vehicle, 5.0)
        vehicle.set_wind(wind)
        end = later(vehicle, 60.0)
        assert end.pose.position_enu == (120.0, 0.0, 20.0)
        charges.append(end.battery_fraction)
    assert charges[1] < charges[0] - 0.001


def test_a_velocity_goes_on_in_another_wind_for_the_rest_of_its_time() -> None:
    """Neither its end nor what it does is changed."""
    vehicle = in_the_air()
    vehicle.fly_at((3.0, 0.0, 0.0), 10.0)
    later(vehicle, 4.0)
    vehicle.set_wind((4.0, 0.0))
    assert later(vehicle, 5.9).pose.velocity_enu == pytest.approx((3.0, 0.0, 0.0))
    assert later(vehicle, 6.0).pose.motion.is_still


def test_its_own_speeds_limit_every_order() -> None:
    """The direction over ground stays."""
    vehicle = in_the_air()
    vehicle.fly_at((30.0, 40.0, 9.0), 8.0)
    east, north, up = later(vehicle, 7.0).pose.velocity_enu
    assert (east, north, up) == pytest.approx((4.8, 6.4, 3.0))
    vehicle = in_the_air()
    vehicle.fly_along([(200.0, 25.0, 10.0)], 99.0)
    assert later(vehicle, 12.0).pose.speed_mps == pytest.approx(8.0)


def test_turns_at_its_place() -> None:
    """At a yaw rate that vehicles have, the shorter way."""
    vehicle = in_the_air()
    vehicle.turn_to(math.pi / 2)
    assert later(vehicle, 1.0).pose.yaw_rad == pytest.approx(math.pi / 4, abs=0.01)
    end = later(vehicle, 3.0)
    assert end.pose.yaw_rad == pytest.approx(math.pi / 2)
    assert end.pose.position_enu == UP


def test_a_restart_changes_nothing(tmp_path: Path) -> None:
    """In the middle of a velocity, and of a way along places."""
    orders = (
        lambda v: v.fly_at((3.0, -2.0, 0.2), 9.0, 0.1),
        lambda v: v.fly_along(PLACES, 6.0),
    )
    for order in orders:
        vehicle = in_the_air()
        order(vehicle)
        later(vehicle, 3.0)
        write_journal(tmp_path / 'journal.json', vehicle.record)
        again = FreeVehicle(AIRFRAME, HOME)
        again.restore(read_journal(tmp_path / 'journal.json'))
        for seconds in (0.0, 1.7, 20.0):
            now_ns = vehicle.time_ns + round(seconds * NS_PER_S)
            assert again.step(now_ns) == vehicle.step(now_ns)


@pytest.mark.parametrize(
    ('order', 'words'),
    [
        (lambda v: v.fly_at((math.nan, 0.0, 0.0), 1.0), 'three finite numbers'),
        (lambda v: v.fly_at((1.0, 0.0, 0.0), -1.0), 'duration_s is -1'),
        (lambda v: v.fly_at((1.0, 0.0, 0.0), 10.0, 7.0), 'turn_rate_radps is 7'),
        (lambda v: v.fly_at((1.0, 0.0, 0.0), 10.0, 0.0, math.nan), 'yaw_rad is nan'),
        (lambda v: v.set_wind((math.nan, 0.0)), 'wind_mps is nan'),
        (lambda v: v.set_wind((80.0, 0.0)), 'wind_mps is 80'),
        (lambda v: v.fly_along([(0.0, 0.0, -1.0)]), 'height_m is -1'),
        (lambda v: v.fly_along([(0.0, math.nan, 9.0)]), 'three finite numbers'),
        (lambda v: v.fly_along([]), 'must be one at least'),
        (lambda v: v.fly_along([UP], -1.0), 'speed_mps is -1'),
        (lambda v: v.turn_to(math.inf), 'yaw_rad is inf'),
    ],
)
def test_nonsense_is_refused(order, words: str) -> None:
    """And the vehicle stands where it was."""
    vehicle = in_the_air()
    with pytest.raises(ValueError, match=words):
        order(vehicle)
    assert later(vehicle, 5.0).pose.position_enu == UP


def test_orders_on_the_ground_and_outside_the_fence_are_refused() -> None:
    """A velocity, a turn, and whatever leaves the fence."""
    vehicle = FreeVehicle(AIRFRAME, HOME)
    vehicle.step(START_NS)
    for order in (lambda: vehicle.fly_at((1.0, 0.0, 0.0), 1.0), lambda: vehicle.turn_to(1.0)):
        with pytest.raises(CommandRefusedError, match='disarmed'):
            order()
    vehicle = in_the_air()
    corners = ((-60.0, 0.0), (60.0, 0.0), (60.0, 60.0), (-60.0, 60.0))
    vehicle.push_fence(Fence(inclusions=(corners,)))
    with pytest.raises(CommandRefusedError, match='leaves the fence'):
        vehicle.fly_at((0.0, -6.0, 0.0), 20.0)
    with pytest.raises(CommandRefusedError, match='leaves the fence'):
        vehicle.fly_along([(0.0, -50.0, 20.0)])


def test_a_route_is_gone_on_with_after_a_movement() -> None:
    """A movement is an interruption, as go_to is; without a route there is nothing to resume."""
    vehicle = vehicle_on(kind=FreeVehicle)
    at_s(vehicle, 36.0)
    vehicle.fly_at((2.0, 0.0, 0.0), 3.0)
    at_s(vehicle, 50.0)
    vehicle.resume()
    assert at_s(vehicle, 400.0).viewpoints_visited == 4
    with pytest.raises(CommandRefusedError, match='no route'):
        in_the_air().resume()


def test_its_battery_ends_a_free_flight_in_time() -> None:
    """Forgotten in the air it lands at home with its reserve."""
    vehicle = in_the_air(endurance_s=200.0)
    vehicle.fly_at((4.0, 0.0, 0.0), 600.0)
    seen = at_s(vehicle, 700.0)
    assert seen.mode is Mode.LANDED
    assert seen.pose.position_enu == pytest.approx(HOME)
    assert seen.battery_fraction >= AIRFRAME.reserve_fraction
