# SPDX-License-Identifier: Apache-2.0
"""A vehicle follows velocities under a deadline, and gives way to every other order."""

import math
from contextlib import suppress

import pytest
from test.sim.flights import AIRFRAME, HOME, START_NS
from test.sim.test_free_vehicle import in_the_air, later

from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.fence import Fence
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.free_vehicle import FreeVehicle
from rocsafe_sim.vehicle.velocity_follower import VelocityFollower

EAST = (3.0, 0.0, 0.0)


def flying(deadline_s: float = 0.5) -> tuple[FreeVehicle, VelocityFollower]:
    """Return a vehicle that follows velocities."""
    vehicle = in_the_air()
    return vehicle, VelocityFollower(vehicle, deadline_s)


def follow(follower, velocity=EAST, turn_radps=0.0, stamp_ns=0, *, is_of_body=False) -> None:
    """Send a velocity."""
    follower.follow(velocity, turn_radps, stamp_ns, is_of_body=is_of_body)


@pytest.mark.slow
def test_velocities_that_keep_coming_are_flown() -> None:
    """Without a stop between; it turns meanwhile, and ahead turns with it."""
    vehicle, follower = flying()
    for _ in range(20):
        follow(follower)
        later(vehicle, 0.2)
    assert vehicle.pose_at(vehicle.time_ns).velocity_enu == pytest.approx(EAST, abs=0.02)
    for _ in range(50):
        follow(follower, (2.0, 0.0, 0.0), 0.3, is_of_body=True)
        seen = later(vehicle, 0.2)
    heading = math.atan2(seen.pose.velocity_enu[1], seen.pose.velocity_enu[0])
    assert math.cos(heading - seen.pose.yaw_rad) > 0.9
    assert not follower.is_over


def test_it_stands_at_the_deadline_and_goes_on_with_the_next_message() -> None:
    """The deadline is part of each order: nobody has to watch it."""
    vehicle, follower = flying()
    follow(follower)
    later(vehicle, 0.4)
    assert vehicle.mode is Mode.FLYING
    place = later(vehicle, 5.0).pose.position_enu
    assert vehicle.stands
    assert place == later(vehicle, 20.0).pose.position_enu
    follow(follower)
    assert later(vehicle, 0.4).pose.velocity_enu[0] > 0.0


@pytest.mark.parametrize('order', ['hold', 'land', 'return_home', 'elsewhere', 'turn'])
def test_every_other_order_ends_it(order: str) -> None:
    """And what was ordered stays in force."""
    vehicle, follower = flying()
    follow(follower)
    later(vehicle, 0.2)
    given = {
        'elsewhere': lambda: vehicle.fly_along([(0.0, 0.0, 30.0)]),
        'turn': lambda: vehicle.turn_to(1.0),
    }
    given.get(order, lambda: getattr(vehicle, order)())()
    assert follower.is_over


@pytest.mark.slow
def test_a_failsafe_of_the_vehicle_ends_it() -> None:
    """A low battery takes it home, although velocities keep coming."""
    vehicle = in_the_air(endurance_s=150.0)
    follower = VelocityFollower(vehicle, 1.0)
    for _ in range(2000):
        if follower.is_over:
            break
        with suppress(CommandRefusedError):
            follow(follower)
        later(vehicle, 0.2)
    assert later(vehicle, 200.0).mode is Mode.LANDED
    assert vehicle.observe().battery_fraction >= AIRFRAME.reserve_fraction


@pytest.mark.parametrize(
    ('sent', 'words'),
    [
        ({'velocity': (math.nan, 0.0, 0.0)}, 'three finite numbers'),
        ({'turn_radps': math.inf}, 'turn_rate_radps'),
        ({'stamp_ns': START_NS}, 's old'),
        ({'stamp_ns': START_NS + 10**15}, 's ahead of simulated time'),
        ({'velocity': (0.0, -8.0, 0.0)}, 'leaves the fence'),
    ],
)
def test_what_is_refused_counts_as_no_message(sent, words: str) -> None:
    """The velocity before is flown to its deadline, and no longer."""
    vehicle, follower = flying()
    # The ways to and from a stop take some metres.
    corners = ((-60.0, HOME[1] - 3.0), (90.0, HOME[1] - 3.0), (90.0, 60.0), (-60.0, 60.0))
    vehicle.push_fence(Fence(inclusions=(corners,)))
    follow(follower)
    later(vehicle, 0.2)
    refusals = []
    for _ in range(20):
        try:
            follow(follower, **sent)
        except (CommandRefusedError, ValueError) as refusal:
            refusals.append(str(refusal))
        later(vehicle, 0.2)
    assert words in refusals[0]
    later(vehicle, 10.0)
    assert vehicle.stands
    assert vehicle.record.fence.holds([vehicle.pose_at(vehicle.time_ns).position_enu])


def test_it_begins_in_the_air_with_a_deadline_that_ends() -> None:
    """On the ground, or with a deadline beyond 5 s, it is refused."""
    vehicle = FreeVehicle(AIRFRAME, HOME)
    vehicle.step(START_NS)
    with pytest.raises(CommandRefusedError, match='disarmed'):
        VelocityFollower(vehicle, 0.5)
    for deadline_s in (0.0, 6.0, math.nan):
        with pytest.raises(ValueError, match='duration_s'):
            VelocityFollower(in_the_air(), deadline_s)
