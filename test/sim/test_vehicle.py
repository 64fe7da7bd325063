# SPDX-License-Identifier: Apache-2.0
"""Flights of a vehicle: how long, how fast, where, and that steps and restarts do not matter."""

import math
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test.sim.flights import (
    AIRFRAME,
    HOME,
    START_NS,
    airframes,
    at_s,
    routes,
    steps,
    vehicle_on,
)

from rocsafe_sim.errors import JournalError
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.route import FlightRoute, RouteWaypoint
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.flight_record import FlightOutcome
from rocsafe_sim.vehicle.journal import read_journal, write_journal
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle
from rocsafe_sim.vehicle.snapshot import ShotDue


def planned_duration_s(airframe: Airframe, route: FlightRoute, height_m: float) -> float:
    """Return the planner's time model: climb, stop-to-stop legs, hovers, home, descent."""
    performance = airframe.performance
    stops = np.array([HOME, *(w.position_enu for w in route.waypoints), HOME])
    legs = performance.legs_s(np.diff(stops[:, :2], axis=0)).sum()
    vertical = performance.ascent_s(height_m) + performance.descent_s(height_m)
    return float(legs) + vertical + airframe.hover_s * len(route.waypoints)


def level(route: FlightRoute, height_m: float) -> FlightRoute:
    """Return `route` with all viewpoints at one height."""
    return replace(
        route,
        waypoints=tuple(
            replace(w, position_enu=(*w.position_enu[:2], height_m)) for w in route.waypoints
        ),
    )


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(airframes(), routes())
def test_flight_takes_the_time_the_planner_says(airframe: Airframe, drawn: FlightRoute) -> None:
    """Take-off to standing motors equals climb + legs + hovers + descent to a nanosecond."""
    route = level(drawn, 32.0)
    airframe = replace(airframe, hover_s=max(airframe.hover_s, 0.1))
    vehicle = vehicle_on(route, airframe)
    assert vehicle.left()[1] == pytest.approx(planned_duration_s(airframe, route, 32.0), abs=1e-9)
    at_s(vehicle, 1e6)
    summary = vehicle.summary()
    assert summary is not None
    assert summary.duration_s == pytest.approx(planned_duration_s(airframe, route, 32.0), abs=1e-9)
    assert summary.outcome is FlightOutcome.COMPLETED


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(airframes(), routes(), st.floats(0.3, 1.7))
def test_never_faster_than_allowed_and_ends_at_home(
    airframe: Airframe, route: FlightRoute, step_s: float
) -> None:
    """Speed and acceleration keep their limits; every viewpoint is photographed; home at the end.

    Where viewpoints are passed, both legs of a corner may add up, and it is passed within the
    radius.
    """
    performance = airframe.performance
    # in a corner that is passed two legs are flown at once
    both = 2.0 if airframe.hover_s == 0.0 else 1.0
    hardest = both * math.hypot(performance.acceleration_mps2, 1e-9)
    shots: list[ShotDue] = []
    last = None
    for seen in steps(vehicle_on(route, airframe), step_s):
        east, north, up = seen.pose.velocity_enu
        assert math.hypot(east, north) <= both * performance.cruise_speed_mps * (1 + 1e-9)
        assert -performance.descent_rate_mps - 1e-9 <= up <= performance.climb_rate_mps + 1e-9
        if last is not None:
            change = math.dist(last.velocity_enu[:2], (east, north))
            assert change <= hardest * step_s * (1 + 1e-6) + 1e-9
        last = seen.pose
        shots += seen.shots
    assert [s.viewpoint_id for s in shots] == [w.viewpoint_id for w in route.waypoints]
    off_m = [
        math.dist(s.pose.position_enu, w.position_enu)
        for s, w in zip(shots, route.waypoints, strict=True)
    ]
    assert max(off_m) <= (0.0 if airframe.hover_s else performance.corner_radius_m)
    assert [s.sequence for s in shots] == list(range(len(shots)))
    assert last is not None
    assert last.position_enu == HOME


def test_velocity_is_the_slope_of_position() -> None:
    """Central differences of the position give the velocity, in every phase."""
    half_ns = 100_000
    vehicle = vehicle_on()
    for tick in range(1, 580):
        middle_ns = START_NS + tick * 203_000_000
        a, b, c = (vehicle.step(middle_ns + d).pose for d in (-half_ns, 0, half_ns))
        if math.dist(a.velocity_enu, c.velocity_enu) < 1e-3:
            ends = (a.position_enu, c.position_enu)
            slope = [(x1 - x0) / 2e-4 for x0, x1 in zip(*ends, strict=True)]
            assert slope == pytest.approx(b.velocity_enu, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize('step_s', [0.02, 0.37, 5.0, 1000.0])
def test_step_size_changes_nothing(step_s: float) -> None:
    """Shots, their times and the pose at a given time are those of the finest steps."""
    reference = vehicle_on()
    expected = [shot for seen in steps(reference, 0.05) for shot in seen.shots]
    vehicle = vehicle_on()
    assert [shot for seen in steps(vehicle, step_s) for shot in seen.shots] == expected
    assert vehicle.summary() == reference.summary()


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(st.floats(0.0, 120.0), st.sampled_from(['', 'hold', 'return_home', 'land', 'cancel']))
def test_restored_vehicle_has_the_same_future(killed_s: float, command: str) -> None:
    """A vehicle restored from its journal at any instant goes on as if nothing had happened."""
    survivor = vehicle_on()
    at_s(survivor, killed_s)
    if command and survivor.mode is Mode.FLYING:
        getattr(survivor, command)()
    restored = SimulatedVehicle(AIRFRAME, HOME)
    with TemporaryDirectory() as folder:
        path = Path(folder) / 'journal.json'
        write_journal(path, survivor.record)
        record = read_journal(path)
    assert record == survivor.record
    restored.restore(record)
    for later_s in (0.0, 0.05, 3.3, 20.0, 200.0, 5000.0):
        assert at_s(restored, killed_s + later_s) == at_s(survivor, killed_s + later_s)
    assert restored.summary() == survivor.summary()


def test_photograph_lost_by_a_kill_is_taken_again() -> None:
    """A journal older than a shot lets the restored vehicle take that shot, the same one."""
    vehicle = vehicle_on()
    record = vehicle.record
    taken = at_s(vehicle, 45.0).shots
    restored = SimulatedVehicle(AIRFRAME, HOME)
    restored.restore(record)
    assert len(taken) > 1
    assert at_s(restored, 45.0).shots == taken


@pytest.mark.parametrize('content', ['', '{}', '{"format": 99}', '[1]', '{"format": 1}'])
def test_damaged_journal_is_refused(tmp_path: Path, content: str) -> None:
    """What is not a journal is named with its path."""
    path = tmp_path / 'journal.json'
    path.write_text(content)
    with pytest.raises(JournalError, match=r'journal\.json'):
        read_journal(path)


def test_no_journal_is_none(tmp_path: Path) -> None:
    """A vehicle that never wrote one starts afresh."""
    assert read_journal(tmp_path / 'journal.json') is None


def test_same_position_twice_is_two_photographs() -> None:
    """A leg of no length takes no time, and its viewpoint counts."""
    twice = RouteWaypoint(viewpoint_id=0, position_enu=(0.0, 0.0, 20.0), yaw_rad=0.0)
    route = FlightRoute(
        plan_id='p', home_enu=HOME, waypoints=(twice, replace(twice, viewpoint_id=1))
    )
    shots = [shot for seen in steps(vehicle_on(route), 0.5) for shot in seen.shots]
    assert shots[1].time_ns - shots[0].time_ns == round(AIRFRAME.hover_s * 1e9)


def test_time_does_not_run_backwards() -> None:
    """A step into the past is a fault of the caller."""
    vehicle = vehicle_on()
    at_s(vehicle, 5.0)
    with pytest.raises(ValueError, match='time_ns'):
        vehicle.step(START_NS)


BENT = FlightRoute(
    plan_id='plan-2',
    home_enu=HOME,
    waypoints=(
        RouteWaypoint(viewpoint_id=0, position_enu=(0.0, 0.0, 32.0), yaw_rad=0.5),
        RouteWaypoint(
            viewpoint_id=1,
            position_enu=(60.0, 0.0, 32.0),
            yaw_rad=0.5,
            approach_enu=((0.0, 40.0, 32.0), (60.0, 40.0, 32.0)),
        ),
    ),
    homeward_enu=((60.0, -40.0, 32.0),),
)


def test_bends_are_flown_without_photographs():
    """Round three sides of a square, home over a corner; two photographs."""
    vehicle = vehicle_on(BENT)
    flown = list(steps(vehicle, 0.5))
    assert flown[-1].shots_taken == 2
    places = [snapshot.pose.position_enu for snapshot in flown]
    for corner in ((0.0, 40.0), (60.0, 40.0), (60.0, -40.0)):
        assert min(math.dist(place[:2], corner) for place in places) < 0.6
    assert not any(5.0 < e < 55.0 and 0.5 < n < 35.0 and u > 31.9 for e, n, u in places)


def test_a_stopped_vehicle_goes_on_where_it_was():
    """Held on the second side of three, it does not return to the first bend."""
    assert BENT.way_to(1, (0.0, 20.0, 32.0)) == BENT.waypoints[1].approach_enu
    assert BENT.way_to(1, (30.0, 41.0, 32.0)) == ((60.0, 40.0, 32.0),)
    assert BENT.way_to(1, (61.0, 20.0, 32.0)) == ()
    assert BENT.way_to(2, (60.0, -10.0, 32.0)) == BENT.homeward_enu
