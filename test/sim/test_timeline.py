# SPDX-License-Identifier: Apache-2.0
"""Timelines: segments without gaps, motion without jumps, and the battery's way back."""

import math
from dataclasses import replace
from itertools import pairwise
from unittest import mock

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test.sim.flights import AIRFRAME, HOME, ROUTE, airframes, routes

from rocsafe_sim.flight.battery import CHECK_PERIOD_S, low_battery_s, return_duration_s
from rocsafe_sim.flight.commands import Command, CommandKind, timeline_of
from rocsafe_sim.flight.segment import Mode, standing
from rocsafe_sim.flight.tasks import fly_timeline, hold_timeline, land_timeline
from rocsafe_sim.flight.timeline import Timeline

AT_HOME = standing(HOME, 0.0)
SHARES = st.floats(0.0, 1.0)


def flown(airframe=AIRFRAME, route=ROUTE):
    """Return the timeline of a whole flight."""
    return fly_timeline(airframe, AT_HOME, route, (0, 0))


def diverted(airframe, start, route):
    """Return the timeline of a vehicle that gives up its route at a pose."""
    command = Command(
        kind=CommandKind.DIVERT, start_ns=0, start=start, first_index=0, charge_fraction=1.0,
        distance_m=0.0,
    )  # fmt: skip
    return timeline_of(command, route, airframe)


@settings(max_examples=40, deadline=None)
@given(airframes(), routes())
def test_segments_follow_each_other_without_gaps(airframe, route):
    """They span the flight; each viewpoint is photographed once, at the end of a segment."""
    timeline = flown(airframe, route)
    segments = timeline.segments
    assert segments[0].begin_s == 0.0
    assert segments[-1].end_s == pytest.approx(timeline.duration_s)
    assert all(a.end_s == b.begin_s for a, b in pairwise(segments))
    assert [shot.viewpoint_index for shot in timeline.shots()] == [*range(len(route.waypoints))]
    ends = {segment.end_s for segment in segments}
    assert all(shot.elapsed_s in ends for shot in timeline.shots())


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(airframes(), routes(), SHARES)
def test_nothing_jumps(airframe, route, share):
    """Within a millisecond place, yaw, distance and energy change as rates allow."""
    timeline = flown(airframe, route)
    time_s = share * timeline.duration_s
    now, later = timeline.pose(time_s), timeline.pose(time_s + 1e-3)
    fastest = 2.0 * math.hypot(airframe.performance.cruise_speed_mps, 12.0)
    assert math.dist(now.position_enu, later.position_enu) <= fastest * 1e-3
    assert (
        0.0 <= timeline.progress_m(time_s + 1e-3) - timeline.progress_m(time_s) <= fastest * 1e-3
    )
    used = timeline.used_j(time_s + 1e-3) - timeline.used_j(time_s)
    assert used == pytest.approx(1e-3 * timeline.power_w(time_s), rel=1e-2, abs=1e-3)


def test_modes_come_in_their_order():
    """Take-off, flight, return, landing; before the start and after the end it stands."""
    timeline = flown()
    modes = [mode for mode, after in pairwise([*(s.mode for s in timeline.segments), None])
             if mode is not after]  # fmt: skip
    assert modes == [Mode.TAKING_OFF, Mode.FLYING, Mode.RETURNING, Mode.LANDING]
    assert timeline.first_start_s(Mode.HOLDING) == math.inf
    assert 0.0 < timeline.first_start_s(Mode.FLYING) < timeline.first_start_s(Mode.LANDING)
    assert timeline.first_start_s(Mode.LANDING, Mode.FLYING) == timeline.first_start_s(Mode.FLYING)
    for time_s in (-5.0, timeline.duration_s + 5.0):
        assert timeline.pose(time_s).motion.is_still
        assert timeline.pose(time_s).position_enu == HOME


@settings(max_examples=30, deadline=None)
@given(airframes(), routes(), SHARES)
def test_a_hold_stops_near_and_lasts(airframe, route, share):
    """From any motion it comes to rest, and stays there for ever."""
    timeline = flown(airframe, route)
    start = timeline.pose(share * timeline.duration_s)
    held = hold_timeline(airframe, start)
    assert held.duration_s == math.inf
    assert held.pose(0.0).position_enu == pytest.approx(start.position_enu)
    assert held.pose(0.0).velocity_enu == pytest.approx(start.velocity_enu)
    rest = held.pose(1e5)
    assert rest.motion.is_still
    assert rest.position_enu == held.pose(2e5).position_enu


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(airframes(), routes(), SHARES)
def test_a_landing_ends_below_where_it_stopped(airframe, route, share):
    """It goes straight down to the ground."""
    start = flown(airframe, route).pose(share * flown(airframe, route).duration_s)
    stopped_at = hold_timeline(airframe, start).pose(1e5).position_enu
    landed = land_timeline(airframe, start, route)
    end = landed.pose(landed.duration_s).position_enu
    assert end[:2] == pytest.approx(stopped_at[:2])
    assert end[2] == pytest.approx(HOME[2])


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(airframes(), routes(), SHARES)
def test_the_way_back_takes_as_long_as_it_is_reckoned(airframe, route, share):
    """The quick reckoning of the battery's watch equals the flight that then follows."""
    timeline = flown(airframe, route)
    start = timeline.pose(share * timeline.duration_s)
    reckoned_s = return_duration_s(airframe, start, route)
    assert reckoned_s == pytest.approx(diverted(airframe, start, route).duration_s, abs=1e-6)


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(airframes(), routes(), st.floats(0.2, 0.95))
def test_it_turns_back_with_enough_charge_and_not_long_before(airframe, route, share):
    """A battery for a part of the flight is called low in time to land with the reserve."""
    endurance_s = share * flown(airframe, route).duration_s / (1.0 - airframe.reserve_fraction)
    airframe = replace(airframe, endurance_s=endurance_s)
    timeline = flown(airframe, route)
    low_s = low_battery_s(airframe, timeline, 1.0, route)
    if low_s in (0.0, math.inf):
        return
    assert low_s % CHECK_PERIOD_S == 0.0
    back = diverted(airframe, timeline.pose(low_s), route)
    used = timeline.used_j(low_s) + back.used_j(back.duration_s)
    left = 1.0 - used / airframe.power.capacity_j
    assert left >= airframe.reserve_fraction - 1e-9


@pytest.mark.slow
@settings(max_examples=20, deadline=None)
@given(airframes(), routes(), SHARES, st.floats(0.3, 1.0))
def test_a_stand_without_end_is_left_as_if_it_were_checked_all_the_time(
    airframe, route, share, charge
):
    """A stand is known to cost the same at all times, which saves all checks but the last."""
    timeline = flown(airframe, route)
    stand = hold_timeline(airframe, timeline.pose(share * timeline.duration_s))
    quick_s = low_battery_s(airframe, stand, charge, route)
    with mock.patch.object(Timeline, 'stands_from_s', math.inf):
        assert quick_s == low_battery_s(airframe, stand, charge, route)
