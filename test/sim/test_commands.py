# SPDX-License-Identifier: Apache-2.0
"""Orders to a vehicle: which are obeyed when, what they do, how a flight then ends."""

import copy
import functools
import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from test.fakes.verb_table import VERBS, Answer, answers
from test.sim.flights import AIRFRAME, HOME, ROUTE, START_NS, at_s, steps, vehicle_on

from rocsafe_geo.motion.state import Enu
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.fence import Fence
from rocsafe_sim.flight.route import FlightRoute
from rocsafe_sim.flight.segment import Mode, standing
from rocsafe_sim.vehicle.flight_record import FlightOutcome
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle

AROUND = ((-90.0, -90.0), (90.0, -90.0), (90.0, 90.0), (-90.0, 90.0))
AWAY = (60.0, -30.0, 20.0)
COMMANDS: dict[str, Callable[[SimulatedVehicle], None]] = {
    'hold': SimulatedVehicle.hold,
    'resume': SimulatedVehicle.resume,
    'return_home': SimulatedVehicle.return_home,
    'land': SimulatedVehicle.land,
    'go_to': lambda vehicle: vehicle.go_to(AWAY),
    'set_speed': lambda vehicle: vehicle.set_speed(4.0),
    'set_home': lambda vehicle: vehicle.set_home(AWAY),
    'fence': lambda vehicle: vehicle.push_fence(Fence(inclusions=(AROUND,))),
    'rally': lambda vehicle: vehicle.push_rally((AWAY,)),
}
# seconds after take-off at which the flight of ROUTE is in each mode
TIMES_S = {Mode.TAKING_OFF: 5.0, Mode.FLYING: 36.0, Mode.RETURNING: 70.0, Mode.LANDING: 90.0}
# full acceleration takes 2 s to let go of, on the way to 8 m/s; then 8 m/s take 4 s and 2 s
LONGEST_STOP_S = 2.0 + 4.0 + 2.0
LONGEST_STOP_M = 8.0 * 2.0 + 0.5 * 8.0 * 6.0


class Ceiling:
    """Surroundings that nobody flies through at 20 m."""

    def ground_up_m(self, _east_m: float, _north_m: float) -> float:
        """Return level ground."""
        return 0.0

    def touched(self, place_enu: Enu, _radius_m: float) -> str:
        """Return whether the ceiling is reached."""
        return 'ceiling' if place_enu[2] > 20.0 else ''


def vehicle_in(mode: Mode) -> SimulatedVehicle:
    """Return a vehicle that is in `mode`."""
    return copy.deepcopy(_first_vehicle_in(mode))


@functools.cache
def _first_vehicle_in(mode: Mode) -> SimulatedVehicle:
    delay_s = 60.0 if mode is Mode.WAITING else 0.0
    vehicle = vehicle_on(replace(ROUTE, delay_s=delay_s))
    if mode is Mode.DISARMED:
        vehicle = SimulatedVehicle(AIRFRAME, HOME)
    if mode in (Mode.FALLING, Mode.CRASHED):
        vehicle = SimulatedVehicle(AIRFRAME, HOME, Ceiling())
        vehicle.step(START_NS)
        vehicle.fly_route(ROUTE)
        next(seen for seen in steps(vehicle, 0.1) if seen.mode is mode)
    if mode in TIMES_S:
        at_s(vehicle, TIMES_S[mode])
    elif mode is Mode.HOLDING:
        at_s(vehicle, 36.0)
        vehicle.hold()
    elif mode is Mode.LANDED:
        at_s(vehicle, 1000.0)
    assert vehicle.mode is mode
    return vehicle


ANSWERS = answers(is_real=False)


@pytest.mark.slow
@pytest.mark.parametrize('mode', list(Mode))
@pytest.mark.parametrize('command', [*VERBS, 'set_home'])
def test_every_order_has_its_answer_in_every_state(mode: Mode, command: str) -> None:
    """By the table of orders and states; a refusal says what the state is."""
    vehicle = vehicle_in(mode)
    before = vehicle.record
    home = Answer.OBEYED if mode is Mode.DISARMED else Answer.REFUSED
    answer = ANSWERS.get((mode.value, command), home)
    if answer is Answer.REFUSED:
        with pytest.raises(CommandRefusedError, match=mode.value):
            COMMANDS[command](vehicle)
    else:
        COMMANDS[command](vehicle)
    assert (vehicle.record != before) is (answer is Answer.OBEYED)


def test_held_on_the_ground_it_takes_off_when_it_is_resumed() -> None:
    """Its wait ends, a battery that would fail does not, and nothing is photographed."""
    vehicle = vehicle_on(replace(ROUTE, delay_s=60.0), replace(AIRFRAME, fails_after_s=200.0))
    vehicle.hold()
    vehicle.hold()
    seen = at_s(vehicle, 1000.0)
    assert (seen.mode, seen.pose.position_enu, seen.shots_taken) == (Mode.WAITING, HOME, 0)
    assert (seen.battery_fraction, seen.power_w) == (1.0, 0.0)
    assert math.isinf(seen.waits_s)
    assert vehicle.summary() is None
    assert restored(vehicle).step(vehicle.time_ns + 1) == vehicle.step(vehicle.time_ns + 1)
    vehicle.resume()
    assert vehicle.mode is Mode.TAKING_OFF
    assert list(steps(vehicle, 1.0))[-1].viewpoints_visited == len(ROUTE.waypoints)


@pytest.mark.parametrize('how', ['resume', 'another route'])
def test_held_on_the_ground_it_waits_for_the_rest_of_its_time(how: str) -> None:
    """Who resumes it early does not bring it nearer to the others; another route has its own."""
    vehicle = vehicle_on(replace(ROUTE, delay_s=60.0))
    at_s(vehicle, 10.0)
    vehicle.hold()
    at_s(vehicle, 30.0)
    route = vehicle.flight.route
    if how == 'resume':
        vehicle.resume()
    else:
        vehicle.fly_route(replace(route, plan_id='plan-2', delay_s=30.0), replaces=True)
    assert at_s(vehicle, 59.0).mode is Mode.WAITING
    assert at_s(vehicle, 61.0).mode is Mode.TAKING_OFF


@pytest.mark.parametrize('held_s', [10.0, 70.0])
def test_the_same_route_again_does_not_end_a_hold(held_s: float) -> None:
    """A mission sends it again to a process that was restarted; a real vehicle joins, too."""
    vehicle = vehicle_on(replace(ROUTE, delay_s=60.0))
    at_s(vehicle, held_s)
    vehicle.hold()
    at_s(vehicle, 100.0)
    again = restored(vehicle)
    again.step(vehicle.time_ns)
    before = again.mode
    again.fly_route(vehicle.flight.route)
    assert at_s(again, 1000.0).mode is before
    again.resume()
    assert at_s(again, 1005.0).mode in (Mode.TAKING_OFF, Mode.FLYING)


def restored(vehicle: SimulatedVehicle) -> SimulatedVehicle:
    """Return a vehicle that continues from the record of another."""
    again = SimulatedVehicle(vehicle.airframe, HOME)
    again.restore(vehicle.record)
    return again


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.floats(0.1, 75.0), st.floats(0.0, 100.0))
def test_hold_stops_and_resume_visits_the_rest(held_s: float, for_s: float) -> None:
    """A hold brakes at once, smoothly; after it all viewpoints are photographed, once each."""
    vehicle = vehicle_on()
    shots = list(at_s(vehicle, held_s).shots)
    before = vehicle.step(vehicle.time_ns).pose
    vehicle.hold()
    assert vehicle.step(vehicle.time_ns).pose == before
    stopped = at_s(vehicle, held_s + LONGEST_STOP_S).pose
    assert stopped.velocity_enu == (0.0, 0.0, 0.0)
    assert math.dist(stopped.position_enu, before.position_enu) <= LONGEST_STOP_M
    shots += at_s(vehicle, held_s + LONGEST_STOP_S + for_s).shots
    vehicle.resume()
    shots += [shot for seen in steps(vehicle, 1.0) for shot in seen.shots]
    assert [s.viewpoint_id for s in shots] == [w.viewpoint_id for w in ROUTE.waypoints]
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.COMPLETED


def test_return_home_ends_at_home() -> None:
    """Told to return, the vehicle lands at home and says that it did so early."""
    vehicle = vehicle_in(Mode.FLYING)
    vehicle.return_home()
    assert vehicle.mode is Mode.RETURNING
    last = list(steps(vehicle, 0.5))[-1]
    assert last.pose.position_enu == HOME
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.RETURNED_EARLY
    assert 0 < summary.viewpoints_visited < len(ROUTE.waypoints)


@pytest.mark.parametrize('command', ['return_home', 'land'])
def test_told_to_return_or_land_while_it_waits_it_never_takes_off(command: str) -> None:
    """A vehicle on the ground stays there, and its flight ends early."""
    vehicle = vehicle_in(Mode.WAITING)
    COMMANDS[command](vehicle)
    seen = at_s(vehicle, 1000.0)
    assert (seen.mode, seen.pose.position_enu) == (Mode.LANDED, HOME)
    assert (seen.shots_taken, seen.distance_flown_m) == (0, 0.0)
    summary = vehicle.summary()
    assert summary is not None
    assert (summary.outcome, summary.viewpoints_visited) == (FlightOutcome.RETURNED_EARLY, 0)


def test_land_comes_down_where_it_can_stop() -> None:
    """Told to land, the vehicle comes down within its braking distance."""
    vehicle = vehicle_in(Mode.FLYING)
    before = vehicle.step(vehicle.time_ns).pose
    vehicle.land()
    last = list(steps(vehicle, 0.5))[-1].pose
    assert last.position_enu[2] == 0.0
    assert math.dist(before.position_enu[:2], last.position_enu[:2]) <= LONGEST_STOP_M
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.RETURNED_EARLY


def test_same_route_joins() -> None:
    """The route being flown, sent again, changes nothing; nor does the one just flown."""
    vehicle = vehicle_in(Mode.FLYING)
    record = vehicle.record
    vehicle.fly_route(replace(ROUTE))
    assert vehicle.record == record
    at_s(vehicle, 1000.0)
    landed = vehicle.summary()
    vehicle.fly_route(ROUTE)
    assert vehicle.summary() == landed
    assert vehicle.is_idle


def test_other_route_is_refused_in_flight_and_flown_after() -> None:
    """Another plan has to wait for the end of this one."""
    other = replace(ROUTE, plan_id='plan-2')
    vehicle = vehicle_in(Mode.FLYING)
    with pytest.raises(CommandRefusedError, match='plan-1'):
        vehicle.fly_route(other)
    at_s(vehicle, 1000.0)
    vehicle.fly_route(other)
    sequences = [shot.sequence for seen in steps(vehicle, 1.0) for shot in seen.shots]
    assert sequences == [4, 5, 6, 7]


def test_cancelled_flight_holds_and_goes_on_when_sent_again() -> None:
    """Cancelled, it holds; the route sent again continues with the viewpoints left."""
    vehicle = vehicle_in(Mode.FLYING)
    visited = vehicle.step(vehicle.time_ns).viewpoints_visited
    vehicle.cancel()
    summary = vehicle.summary()
    assert vehicle.mode is Mode.HOLDING
    assert summary is not None
    assert summary.outcome is FlightOutcome.CANCELLED
    with pytest.raises(CommandRefusedError, match='cancelled'):
        vehicle.resume()
    vehicle.fly_route(ROUTE)
    assert vehicle.summary() is None
    shots = [shot for seen in steps(vehicle, 1.0) for shot in seen.shots]
    assert len(shots) == len(ROUTE.waypoints) - visited


def test_cancelled_flight_can_give_way_to_another_route() -> None:
    """From a hold in the air a new route is flown, the whole of it."""
    vehicle = vehicle_in(Mode.FLYING)
    vehicle.cancel()
    vehicle.fly_route(replace(ROUTE, plan_id='plan-2'))
    shots = [shot for seen in steps(vehicle, 1.0) for shot in seen.shots]
    assert [s.viewpoint_id for s in shots] == [w.viewpoint_id for w in ROUTE.waypoints]


def test_route_from_elsewhere_is_refused() -> None:
    """A route that ends at another vehicle's home is a mistake."""
    vehicle = SimulatedVehicle(AIRFRAME, HOME)
    with pytest.raises(CommandRefusedError, match=r'50\.0 m from home'):
        vehicle.fly_route(replace(ROUTE, home_enu=(10.0, 25.0, 0.0)))


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(st.floats(60.0, 300.0), st.floats(0.0, 0.5), st.sampled_from([0.7, 30.0]))
def test_lands_with_its_reserve(endurance_s: float, reserve: float, step_s: float) -> None:
    """However small the battery: refused, or landed at home with at least the reserve."""
    airframe = replace(AIRFRAME, endurance_s=endurance_s, reserve_fraction=reserve)
    vehicle = SimulatedVehicle(airframe, HOME)
    vehicle.step(START_NS)
    try:
        vehicle.fly_route(ROUTE)
    except CommandRefusedError as refusal:
        assert 'reserve' in str(refusal)  # noqa: PT017
        return
    last = list(steps(vehicle, step_s))[-1]
    assert last.battery_fraction >= reserve - 1e-9
    assert last.pose.position_enu == HOME
    summary = vehicle.summary()
    assert summary is not None
    is_whole = summary.viewpoints_visited == len(ROUTE.waypoints)
    assert summary.outcome is (FlightOutcome.COMPLETED if is_whole else FlightOutcome.BATTERY_LOW)


def test_low_battery_is_not_called_too_early() -> None:
    """The vehicle turns back with no more than the safety margin to spare."""
    airframe = replace(AIRFRAME, endurance_s=120.0, reserve_fraction=0.2)
    vehicle = vehicle_on(airframe=airframe)
    last = list(steps(vehicle, 0.1))[-1]
    # 8 s until the next look, and less power than at full speed for 60 s of return
    assert 0.2 <= last.battery_fraction <= 0.2 + (8.0 + 0.06 * 60.0) / 120.0
    assert 0 < last.viewpoints_visited < len(ROUTE.waypoints)


def test_held_vehicle_returns_before_its_battery_is_empty() -> None:
    """A hold without end is ended by the battery."""
    vehicle = vehicle_in(Mode.HOLDING)
    last = list(steps(vehicle, 5.0))[-1]
    assert last.pose.position_enu == HOME
    assert last.battery_fraction >= AIRFRAME.reserve_fraction
    summary = vehicle.summary()
    assert summary is not None
    assert summary.outcome is FlightOutcome.BATTERY_LOW


def test_distance_is_that_of_the_route() -> None:
    """Flown without commands, the distance is home, viewpoints, home."""
    vehicle = vehicle_on()
    stops = [HOME, *(w.position_enu for w in ROUTE.waypoints), HOME]
    expected = sum(math.dist(a[:2], b[:2]) for a, b in pairwise(stops))
    assert vehicle.left()[0] == pytest.approx(expected)
    assert at_s(vehicle, 1e4).distance_flown_m == pytest.approx(expected)


# Between home and all viewpoints but the first; further to the north than to the south.
WALL = ((5.0, 5.0), (12.0, 5.0), (12.0, 60.0), (5.0, 60.0))
BEHIND_WALL = tuple(
    replace(ROUTE.waypoints[0], viewpoint_id=number, position_enu=place)
    for number, place in enumerate([(0.0, -20.0, 32.0), (40.0, 30.0, 32.0), (60.0, 30.0, 32.0)])
)
WALLED = replace(
    ROUTE,
    waypoints=(
        BEHIND_WALL[0],
        replace(BEHIND_WALL[1], approach_enu=((14.1, 0.0, 32.0),)),
        BEHIND_WALL[2],
    ),
    homeward_enu=((14.1, 2.9, 32.0), (2.9, 2.9, 32.0)),
    exclusions=(WALL,),
    clearance_m=2.0,
)


@pytest.mark.parametrize('why', ['told', 'battery', 'another route'])
def test_giving_up_a_route_goes_around_exclusions(why: str) -> None:
    """Home, or to another route, the vehicle keeps as clear as its route does."""
    vehicle = vehicle_on(WALLED, replace(AIRFRAME, endurance_s=150.0 if why == 'battery' else 1e4))
    flown = []
    while vehicle.mode is not Mode.RETURNING and vehicle.flight.visited < 2:
        flown.append(vehicle.step(vehicle.time_ns + 100_000_000).pose.position_enu[:2])
    if why == 'told':
        vehicle.return_home()
    elif why == 'another route':
        vehicle.cancel()
        west = replace(BEHIND_WALL[0], position_enu=(-20.0, 40.0, 32.0))
        vehicle.fly_route(replace(WALLED, plan_id='plan-2', waypoints=(west,), homeward_enu=()))
    else:
        assert vehicle.flight.ending is FlightOutcome.BATTERY_LOW
    assert flown[-1][0] > 12.0
    flown += [seen.pose.position_enu[:2] for seen in steps(vehicle, 0.1)]
    assert flown[-1] == HOME[:2]
    assert shapely.distance(shapely.LineString(flown), shapely.Polygon(WALL)) >= 2.0 - 0.03


# Four walls about a place, and a place within.
ENCLOSED = replace(
    WALLED,
    plan_id='enclosed',
    waypoints=(replace(BEHIND_WALL[0], position_enu=(-20.0, 100.0, 32.0)),),
    homeward_enu=(),
    exclusions=(
        ((-50.0, 70.0), (10.0, 70.0), (10.0, 80.0), (-50.0, 80.0)),
        ((-50.0, 120.0), (10.0, 120.0), (10.0, 130.0), (-50.0, 130.0)),
        ((-50.0, 70.0), (-40.0, 70.0), (-40.0, 130.0), (-50.0, 130.0)),
        ((0.0, 70.0), (10.0, 70.0), (10.0, 130.0), (0.0, 130.0)),
    ),
)


@pytest.mark.parametrize('is_airborne', [False, True], ids=['on the ground', 'in the air'])
@pytest.mark.parametrize(
    'route',
    [ENCLOSED, replace(WALLED, plan_id='through', homeward_enu=())],
    ids=['no way leads there', 'its way home leads through'],
)
def test_route_across_an_exclusion_is_refused(route: FlightRoute, is_airborne: bool) -> None:
    """On the ground and in the air; the flight under way goes on."""
    vehicle = vehicle_on(ROUTE if is_airborne else replace(ROUTE, delay_s=100.0))
    at_s(vehicle, 30.0)
    with pytest.raises(CommandRefusedError, match=r'exclusion \d lies on leg \d of the way'):
        vehicle.fly_route(route, replaces=True)
    assert vehicle.flight.route.plan_id == ROUTE.plan_id
    assert vehicle.mode.is_airborne is is_airborne


def test_held_route_is_resumed_on_a_free_way_only() -> None:
    """It stands where no way leads out (by a record of another process); nor does it go in."""
    vehicle = vehicle_on(replace(ENCLOSED, waypoints=WALLED.waypoints[:1]))
    at_s(vehicle, 15.0)
    with pytest.raises(CommandRefusedError, match='no way around the exclusions'):
        vehicle.go_to((-20.0, 100.0, 32.0))
    vehicle.hold()
    at_s(vehicle, 25.0)
    flight = vehicle.flight
    inside = standing((-20.0, 100.0, 32.0), 0.0)
    vehicle.restore(
        replace(
            vehicle.record, flight=replace(flight, command=replace(flight.command, start=inside))
        )
    )
    with pytest.raises(CommandRefusedError, match=r'exclusion \d lies on leg 1 of the way'):
        vehicle.resume()
    assert vehicle.mode is Mode.HOLDING
