# SPDX-License-Identifier: Apache-2.0
"""What a simulated vehicle can do like a real one: go to, speed, fence, rally, home."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from test.sim.flights import AIRFRAME, HOME, ROUTE, START_NS, at_s, steps, vehicle_on

from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.fence import Fence
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.flight_record import FlightOutcome
from rocsafe_sim.vehicle.journal import read_journal, write_journal
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle

AWAY = (60.0, -30.0, 50.0)
AROUND = ((-50.0, -50.0), (100.0, -50.0), (100.0, 60.0), (-50.0, 60.0))
# East of the third viewpoint, on the way from the second to it.
WALL = ((20.0, 10.0), (30.0, 10.0), (30.0, 14.0), (20.0, 14.0))


def test_goes_to_a_place_and_stays_until_resumed() -> None:
    """It climbs before it goes there, stands there, and then photographs the rest once each."""
    vehicle = vehicle_on()
    shots = list(at_s(vehicle, 36.0).shots)
    vehicle.go_to(AWAY)
    seen = [at_s(vehicle, 36.0 + second / 2) for second in range(120)]
    assert seen[2].mode is Mode.FLYING
    level = [one for one in seen if math.dist(one.pose.position_enu[:2], AWAY[:2]) < 10.0]
    assert all(one.pose.position_enu[2] == pytest.approx(AWAY[2]) for one in level)
    assert (seen[-1].mode, seen[-1].pose.position_enu) == (Mode.HOLDING, AWAY)
    assert math.isfinite(vehicle.left()[1])
    vehicle.resume()
    shots += [shot for one in steps(vehicle, 1.0) for shot in one.shots]
    assert [shot.viewpoint_id for shot in shots] == [w.viewpoint_id for w in ROUTE.waypoints]
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.COMPLETED


def test_resumes_on_the_way_to_a_place() -> None:
    """Nobody has to wait until it is there."""
    vehicle = vehicle_on()
    at_s(vehicle, 36.0)
    vehicle.go_to(AWAY)
    at_s(vehicle, 38.0)
    vehicle.resume()
    assert list(steps(vehicle, 1.0))[-1].viewpoints_visited == len(ROUTE.waypoints)


def test_comes_home_from_a_place_before_its_battery_is_empty() -> None:
    """Sent away and forgotten it returns by itself, and lands with its reserve."""
    vehicle = vehicle_on(airframe=replace(AIRFRAME, endurance_s=200.0))
    at_s(vehicle, 30.0)
    vehicle.go_to((300.0, 0.0, 100.0))
    last = list(steps(vehicle, 0.5))[-1]
    assert last.pose.position_enu == HOME
    assert last.battery_fraction >= AIRFRAME.reserve_fraction
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.BATTERY_LOW


def test_other_speed_is_flown_until_the_end_of_the_flight() -> None:
    """Slower from the command on, also after a hold; the next flight has its own speed again."""
    vehicle = vehicle_on()
    at_s(vehicle, 20.0)
    vehicle.set_speed(2.0)
    after = [at_s(vehicle, 25.0 + second / 4) for second in range(40)]
    assert max(one.pose.speed_mps for one in after) == pytest.approx(2.0, abs=1e-6)
    vehicle.hold()
    at_s(vehicle, 60.0)
    vehicle.resume()
    rest = list(steps(vehicle, 0.25))
    assert max(one.pose.speed_mps for one in rest) == pytest.approx(2.0, abs=1e-6)
    vehicle.fly_route(replace(ROUTE, plan_id='next'))
    again = list(steps(vehicle, 0.25))
    assert max(one.pose.speed_mps for one in again) > 5.0


@pytest.mark.parametrize('speed_mps', [0.0, -1.0, 8.1, math.nan])
def test_impossible_speed_is_refused(speed_mps: float) -> None:
    """The number and its limit are named, and nothing changes."""
    vehicle = vehicle_on()
    at_s(vehicle, 20.0)
    before = vehicle.record
    with pytest.raises(ValueError, match='speed_mps'):
        vehicle.set_speed(speed_mps)
    assert vehicle.record == before


def test_nothing_is_flown_that_leaves_the_fence() -> None:
    """A route, a place and a fence that do not go together are refused, whatever comes first."""
    vehicle = SimulatedVehicle(AIRFRAME, HOME)
    vehicle.step(START_NS)
    vehicle.push_fence(Fence(inclusions=(AROUND,), exclusions=(WALL,)))
    with pytest.raises(CommandRefusedError, match='the fence on the way to viewpoint 4'):
        vehicle.fly_route(ROUTE)
    vehicle.push_fence(Fence(inclusions=(AROUND,)))
    vehicle.fly_route(ROUTE)
    at_s(vehicle, 30.0)
    with pytest.raises(CommandRefusedError, match='the way leaves the fence'):
        vehicle.go_to((120.0, 0.0, 30.0))
    with pytest.raises(CommandRefusedError, match='to viewpoint 4'):
        vehicle.push_fence(Fence(exclusions=(WALL,)))
    beside = ((-100.0, 90.0), (100.0, 90.0), (0.0, 120.0))
    with pytest.raises(CommandRefusedError, match='is outside of this fence'):
        vehicle.push_fence(Fence(inclusions=(beside,)))
    assert vehicle.record.fence == Fence(inclusions=(AROUND,))
    vehicle.go_to(AWAY)


@pytest.mark.parametrize(
    'ring', [AROUND[:2], ((0.0, 0.0), (10.0, 10.0), (10.0, 0.0), (0.0, 10.0))]
)
def test_impossible_polygon_is_no_fence(ring: tuple[tuple[float, float], ...]) -> None:
    """Fewer than three corners, and a bow-tie."""
    with pytest.raises(ValueError, match='must have 3 or more, and not cross itself'):
        Fence(inclusions=(ring,))


def test_returns_to_the_nearest_rally_point() -> None:
    """Home counts as one of them."""
    rally = (30.0, 40.0, 0.0)
    vehicle = vehicle_on()
    vehicle.push_rally((rally, (200.0, 200.0, 0.0)))
    at_s(vehicle, 45.0)
    vehicle.return_home()
    assert list(steps(vehicle, 0.5))[-1].pose.position_enu == rally
    other = vehicle_on()
    other.push_rally(((200.0, 200.0, 0.0),))
    at_s(other, 45.0)
    other.return_home()
    assert list(steps(other, 0.5))[-1].pose.position_enu == HOME


def test_home_is_moved_before_the_first_take_off() -> None:
    """The vehicle stands there, and flies routes from there only."""
    vehicle = SimulatedVehicle(AIRFRAME, HOME)
    vehicle.step(START_NS)
    vehicle.set_home((10.0, 10.0, 5.0))
    assert vehicle.home_enu == vehicle.observe().pose.position_enu == (10.0, 10.0, 0.0)
    with pytest.raises(CommandRefusedError, match='home of the route is'):
        vehicle.fly_route(ROUTE)
    vehicle.fly_route(replace(ROUTE, home_enu=(10.0, 10.0, 0.0)))


def test_restart_changes_nothing_of_all_that(tmp_path: Path) -> None:
    """A vehicle that continues from its journal flies on as one that was not interrupted."""

    def told(vehicle: SimulatedVehicle) -> None:
        vehicle.push_fence(Fence(inclusions=(AROUND,)))
        vehicle.push_rally(((30.0, 40.0, 0.0),))
        at_s(vehicle, 20.0)
        vehicle.set_speed(3.0)
        at_s(vehicle, 30.0)
        vehicle.go_to(AWAY)
        at_s(vehicle, 33.3)

    first, second = vehicle_on(), vehicle_on()
    told(first)
    told(second)
    write_journal(tmp_path / 'journal.json', first.record)
    restored = SimulatedVehicle(AIRFRAME, HOME)
    record = read_journal(tmp_path / 'journal.json')
    assert record is not None
    restored.restore(record)
    for vehicle in (restored, second):
        at_s(vehicle, 90.0)
        vehicle.return_home()
    assert list(steps(restored, 0.7)) == list(steps(second, 0.7))
