# SPDX-License-Identifier: Apache-2.0
"""Routes in several flights, late, open, to other places, over hills, in place of others."""

import math
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test.sim.flights import AIRFRAME, HOME, ROUTE, START_NS, at_s, steps, vehicle_on

from rocsafe_geo.motion.state import Enu
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.route import BatterySwap, FlightRoute
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.flight_record import FlightOutcome
from rocsafe_sim.vehicle.journal import read_journal, write_journal
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle

SWAPPED = replace(ROUTE, swaps=(BatterySwap(after=1), BatterySwap(after=3)), swap_s=40.0)
ALL = [waypoint.viewpoint_id for waypoint in ROUTE.waypoints]


def landed(vehicle: SimulatedVehicle) -> Enu:
    """Let a vehicle fly to its end and return where it stands."""
    return list(steps(vehicle, 1.0))[-1].pose.position_enu


def whole_s(route: FlightRoute) -> float:
    """Return the time of a whole flight of a route, from take-off to touch-down."""
    return vehicle_on(route).left()[1]


def test_waits_on_the_ground_until_its_delay_is_over() -> None:
    """Late by exactly the delay, at home, without using its battery; then as without it."""
    early, late = vehicle_on(), vehicle_on(replace(ROUTE, delay_s=37.5))
    assert late.mode is Mode.WAITING
    assert not late.is_idle
    assert late.left()[1] == pytest.approx(early.left()[1] + 37.5)
    waiting = at_s(late, 37.4)
    assert (waiting.pose.position_enu, waiting.battery_fraction) == (HOME, 1.0)
    assert waiting.power_w == 0.0
    at_s(early, 30.0)
    assert at_s(late, 67.5).pose == early.step(early.time_ns).pose
    landed(early), landed(late)
    assert late.summary() == early.summary()


@pytest.mark.parametrize('step_s', [0.05, 7.0, 1e4])
def test_changes_its_battery_at_home(step_s: float) -> None:
    """Three flights with full batteries; their times and the changes add up exactly."""
    vehicle = vehicle_on(SWAPPED)
    shots = [shot for seen in steps(vehicle, step_s) for shot in seen.shots]
    assert [shot.viewpoint_id for shot in shots] == ALL
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.COMPLETED
    parts = [replace(ROUTE, waypoints=ROUTE.waypoints[a:b]) for a, b in ((0, 1), (1, 3), (3, 4))]
    expected = sum(whole_s(part) for part in parts) + 2 * 40.0
    assert summary.duration_s == pytest.approx(expected, abs=1e-6)
    used = 1.0 - vehicle.observe().battery_fraction
    last = vehicle_on(parts[-1])
    at_s(last, 1e4)
    assert used == pytest.approx(1.0 - last.observe().battery_fraction)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.0, 400.0))
def test_restored_vehicle_flies_on_with_its_next_battery(killed_s: float) -> None:
    """Killed at any time, in the air or on the ground, it has the same future."""
    survivor = vehicle_on(replace(SWAPPED, delay_s=20.0))
    at_s(survivor, killed_s)
    restored = SimulatedVehicle(AIRFRAME, HOME)
    restored.restore(survivor.record)
    for later_s in (0.0, 10.0, 100.0, 1e4):
        assert at_s(restored, killed_s + later_s) == at_s(survivor, killed_s + later_s)
    assert restored.summary() == survivor.summary()


def test_journal_keeps_the_whole_route(tmp_path: Path) -> None:
    """Delay, battery changes, landing place, heights: what is read is what was written."""
    route = replace(
        SWAPPED,
        delay_s=3.0,
        landing_enu=(90.0, 0.0, -4.0),
        height_m=30.0,
        swaps=(BatterySwap(after=2, homeward_enu=((1.0, 2.0, 30.0),)),),
    )
    vehicle = vehicle_on(route)
    write_journal(tmp_path / 'journal.json', vehicle.record)
    record = read_journal(tmp_path / 'journal.json')
    assert record == vehicle.record
    assert record.flight.route == route


def test_lands_elsewhere() -> None:
    """At another place; the next route begins there, and one from its old home is refused."""
    place = (90.0, -10.0, 0.0)
    vehicle = vehicle_on(replace(ROUTE, landing_enu=place))
    assert landed(vehicle) == pytest.approx(place)
    with pytest.raises(CommandRefusedError, match='from home'):
        vehicle.fly_route(replace(ROUTE, plan_id='plan-2'))
    vehicle.fly_route(replace(ROUTE, plan_id='plan-2', home_enu=place))
    assert landed(vehicle) == pytest.approx(place)
    assert vehicle.summary().outcome is FlightOutcome.COMPLETED


def test_lands_at_its_last_viewpoint() -> None:
    """An open route ends on the ground below its last photograph, without a way home."""
    vehicle = vehicle_on(replace(ROUTE, is_open=True))
    assert vehicle.left()[0] < vehicle_on().left()[0]
    assert landed(vehicle) == pytest.approx((0.0, 24.0, 0.0))
    assert vehicle.summary().viewpoints_visited == 4


@pytest.mark.parametrize('change', [{'is_open': True}, {'landing_enu': (900.0, 0.0, 0.0)}])
def test_way_home_does_not_count_where_it_lands_elsewhere(change: dict[str, object]) -> None:
    """A one-way flight that the battery lasts for is not called home half-way."""
    far = tuple(
        replace(waypoint, position_enu=(225.0 * number, 25.0, 32.0))
        for number, waypoint in enumerate(ROUTE.waypoints, start=1)
    )
    route = replace(ROUTE, waypoints=far, **change)
    endurance_s = whole_s(route) / (1.0 - AIRFRAME.reserve_fraction)
    assert endurance_s < whole_s(replace(ROUTE, waypoints=far))
    vehicle = vehicle_on(route, replace(AIRFRAME, endurance_s=endurance_s))
    last = list(steps(vehicle, 1.0))[-1]
    assert vehicle.summary().outcome is FlightOutcome.COMPLETED
    assert last.battery_fraction >= AIRFRAME.reserve_fraction


def test_low_battery_ends_at_the_nearest_place_to_land() -> None:
    """With too little charge for its end it lands there early if that is nearer than home."""
    far = tuple(
        replace(waypoint, position_enu=(225.0 * number, 25.0, 32.0))
        for number, waypoint in enumerate(ROUTE.waypoints, start=1)
    )
    place = (450.0, 25.0, 0.0)
    route = replace(ROUTE, waypoints=far, landing_enu=place)
    airframe = replace(AIRFRAME, endurance_s=0.8 * whole_s(route))
    vehicle = vehicle_on(route, airframe)
    assert landed(vehicle) == pytest.approx(place)
    assert vehicle.summary().outcome is FlightOutcome.BATTERY_LOW
    assert vehicle.observe().battery_fraction >= AIRFRAME.reserve_fraction


def test_follows_the_heights_of_its_route() -> None:
    """Over hills: up to its height over home, straight to each place, down where it ends."""
    heights = (30.0, 41.0, 55.0, 24.0)
    hilly = tuple(
        replace(waypoint, position_enu=(*waypoint.position_enu[:2], up))
        for waypoint, up in zip(ROUTE.waypoints, heights, strict=True)
    )
    end = (60.0, 24.0, -6.0)
    vehicle = vehicle_on(replace(ROUTE, waypoints=hilly, height_m=25.0, landing_enu=end))
    seen = list(steps(vehicle, 0.1))
    over_home = [s.pose.position_enu[2] for s in seen if s.mode is Mode.TAKING_OFF]
    assert max(over_home) == pytest.approx(25.0, abs=0.2)
    level = [s.pose.position_enu for s in seen if s.mode is Mode.FLYING]
    assert max(up for _, _, up in level) == pytest.approx(55.0)
    # half-way between two viewpoints it is half-way up: the legs are straight
    middle = min(level, key=lambda place: math.dist(place[:2], (12.0, 0.0)))
    assert middle[2] == pytest.approx(35.5, abs=0.5)
    assert seen[-1].pose.position_enu == pytest.approx(end)


def test_gives_up_a_hilly_route_above_all_of_it() -> None:
    """Told to return from a valley, it climbs to the highest viewpoint before it flies home."""
    low = replace(ROUTE.waypoints[0], position_enu=(60.0, 0.0, 10.0))
    high = replace(ROUTE.waypoints[1], position_enu=(90.0, 0.0, 50.0))
    vehicle = vehicle_on(replace(ROUTE, waypoints=(low, high), height_m=30.0))
    while vehicle.observe().viewpoints_visited < 1:
        vehicle.step(vehicle.time_ns + 100_000_000)
    vehicle.return_home()
    ups = [s.pose.position_enu[2] for s in steps(vehicle, 0.5) if s.mode is Mode.RETURNING]
    assert max(ups) == pytest.approx(50.0)
    assert vehicle.observe().pose.position_enu == HOME


OTHER = replace(ROUTE, plan_id='plan-2', waypoints=ROUTE.waypoints[::-1])


@pytest.mark.parametrize('at', [0.0, 5.0, 36.0, 70.0])
def test_route_replaces_another_wherever_it_is(at: float) -> None:
    """In the air or on the ground the new route is flown instead, the whole of it."""
    vehicle = vehicle_on(replace(ROUTE, delay_s=1.0))
    at_s(vehicle, at)
    vehicle.fly_route(OTHER, replaces=True)
    shots = [shot for seen in steps(vehicle, 1.0) for shot in seen.shots]
    assert [shot.viewpoint_id for shot in shots] == ALL[::-1]
    assert vehicle.summary().outcome is FlightOutcome.COMPLETED
    assert vehicle.observe().pose.position_enu == HOME


def test_route_that_replaces_is_joined_like_any_other() -> None:
    """Sent again, the new route changes nothing."""
    vehicle = vehicle_on()
    at_s(vehicle, 36.0)
    vehicle.fly_route(OTHER, replaces=True)
    record = vehicle.record
    vehicle.fly_route(OTHER, replaces=True)
    assert vehicle.record == record


def test_replaced_in_the_air_by_nothing_it_comes_home() -> None:
    """A route without viewpoints is the way home; on the ground it is refused."""
    empty = replace(ROUTE, plan_id='plan-2', waypoints=())
    vehicle = vehicle_on()
    at_s(vehicle, 36.0)
    vehicle.fly_route(empty, replaces=True)
    assert landed(vehicle) == HOME
    assert vehicle.summary().outcome is FlightOutcome.COMPLETED
    with pytest.raises(CommandRefusedError, match='0 viewpoints'):
        vehicle.fly_route(replace(empty, plan_id='plan-3'))


def test_landing_is_not_replaced() -> None:
    """Who lands lands."""
    vehicle = vehicle_on()
    at_s(vehicle, 90.0)
    with pytest.raises(CommandRefusedError, match='landing'):
        vehicle.fly_route(OTHER, replaces=True)


def test_new_route_waits_for_the_battery_that_is_being_changed() -> None:
    """Replaced while it stands at home for a new battery, it takes off with that, not before."""
    vehicle = vehicle_on(SWAPPED)
    while vehicle.mode is not Mode.WAITING:
        vehicle.step(vehicle.time_ns + 1_000_000_000)
    waits_s = vehicle.waits_s
    assert waits_s > 30.0
    vehicle.fly_route(OTHER, replaces=True)
    assert vehicle.waits_s == pytest.approx(waits_s)
    assert vehicle.observe().battery_fraction == 1.0


def test_told_to_return_while_its_battery_is_changed_it_stays() -> None:
    """No further flight of its route follows; what it photographed counts."""
    vehicle = vehicle_on(SWAPPED)
    while vehicle.mode is not Mode.WAITING:
        vehicle.step(vehicle.time_ns + 1_000_000_000)
    vehicle.return_home()
    last = list(steps(vehicle, 1.0))[-1]
    summary = vehicle.summary()
    assert (last.mode, last.pose.position_enu) == (Mode.LANDED, HOME)
    assert (summary.outcome, summary.viewpoints_visited) == (FlightOutcome.RETURNED_EARLY, 1)


def test_cancelled_while_it_waits_it_stays() -> None:
    """A flight that has not begun never does; the vehicle can be sent elsewhere."""
    vehicle = vehicle_on(replace(ROUTE, delay_s=60.0))
    at_s(vehicle, 10.0)
    vehicle.cancel()
    seen = at_s(vehicle, 1000.0)
    assert (seen.mode, seen.pose.position_enu) == (Mode.LANDED, HOME)
    assert vehicle.summary().outcome is FlightOutcome.CANCELLED
    vehicle.fly_route(OTHER)
    assert not vehicle.is_idle


@pytest.mark.parametrize('step_s', [0.3, 50.0])
def test_failed_battery_brings_it_down_for_good(step_s: float) -> None:
    """At the same time whatever the step, where it is; it never flies again."""
    airframe = replace(AIRFRAME, fails_after_s=40.0)
    vehicle = vehicle_on(airframe=airframe)
    last = list(steps(vehicle, step_s))[-1]
    summary = vehicle.summary()
    assert summary.outcome is FlightOutcome.FAILED
    assert 0 < summary.viewpoints_visited < 4
    assert last.pose.position_enu[2] == 0.0
    assert math.dist(last.pose.position_enu[:2], HOME[:2]) > 20.0
    reference = vehicle_on(airframe=airframe)
    at_s(reference, 1e4)
    assert summary == reference.summary()
    with pytest.raises(CommandRefusedError, match='failed'):
        vehicle.fly_route(OTHER)


def test_swaps_must_rise() -> None:
    """A battery change after more viewpoints than there are is a mistake."""
    with pytest.raises(ValueError, match=r'swaps after \[2, 9\]'):
        replace(ROUTE, swaps=(BatterySwap(after=2), BatterySwap(after=9)))
    assert START_NS > 0


@pytest.mark.parametrize('field', ['delay_s', 'swap_s'])
@pytest.mark.parametrize('wait_s', [-1.0, math.nan, math.inf, 1e308, 86_401.0])
def test_wait_that_no_mission_has_is_refused(field, wait_s):
    """A wild number ended the vehicle's process, or let it begin at once."""
    with pytest.raises(ValueError, match=f'{field} is '):
        replace(ROUTE, **{field: wait_s})
