# SPDX-License-Identifier: Apache-2.0
"""A real ground vehicle is called home by its readings, in time to keep its budget."""

import math

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_interfaces.msg import GeoPoint, GroundRoute, GroundStop
from rocsafe_orchestrator.mission.drive_watch import Reading
from rocsafe_orchestrator.parameters.drive_goal import drive_watch

HOME = GeoPosition(53.28, -9.06, 0.0)
LENGTH_M, SPEED_MPS, PERIOD_S = 40.0, 1.0, 0.2


def place(east_m):
    """Return a place on the way, east of home."""
    return offset(HOME, east_m, 0.0, 0.0)


def rate(east_m, strength):
    """Return the dose rate of a source 5 m beside the end of the way."""
    return 0.1 + strength / ((east_m - LENGTH_M) ** 2 + 25.0)


def route(strength, budget_usv, turn_back_usvh=1e5):
    """Return the way there and back over stops every metre, as planned."""
    easts = [*range(int(LENGTH_M) + 1), *range(int(LENGTH_M) - 1, -1, -1)]
    stops = []
    for number, east in enumerate(easts):
        there = place(float(east))
        dose = rate(east, strength) / SPEED_MPS / 3600.0 if number else 0.0
        point = GeoPoint(latitude=there.latitude_deg, longitude=there.longitude_deg)
        stops.append(GroundStop(position=point, duration_s=1.0, dose_usv=dose))
    return GroundRoute(stops=stops, dose_budget_usv=budget_usv, turn_back_usvh=turn_back_usvh)


def driven(watch, strength):
    """Return where the watch called the vehicle home, and the dose with the way back."""
    dose, now_s = 0.0, 0.0
    for step in range(round(2.0 * LENGTH_M / SPEED_MPS / PERIOD_S)):
        along = step * PERIOD_S * SPEED_MPS
        east = min(along, 2.0 * LENGTH_M - along)
        value = rate(east, strength)
        dose += value * PERIOD_S / 3600.0
        now_s += PERIOD_S
        reading = Reading(stamp_s=now_s, rate_usvh=value, place=place(east), speed_mps=SPEED_MPS)
        if why := watch.read(reading):
            back = sum(rate(k * 0.2, strength) * 0.2 / 3600.0 for k in range(int(east / 0.2)))
            return why, along, dose + back
    return '', math.inf, dose


def planned_usv(strength):
    """Return the dose of the whole way."""
    return sum(stop.dose_usv for stop in route(strength, 1.0).stops)


def test_drive_as_predicted_is_let_go_on():
    """With a tenth more than it takes."""
    watch = drive_watch(route(1e4, 1.1 * planned_usv(1e4)))
    assert driven(watch, 1e4)[0] == ''


@pytest.mark.parametrize('times', [1.5, 3.0, 10.0])
def test_stronger_source_than_planned_turns_it_back_within_its_budget(times):
    """On its own tracks, which take what they took."""
    budget = 1.1 * planned_usv(1e4)
    why, along, dose = driven(drive_watch(route(1e4, budget)), times * 1e4)
    assert 'uSv are used' in why
    assert along < LENGTH_M + 5.0
    assert 0.3 * budget < dose <= budget


def test_level_of_the_dose_rate_turns_it_back_at_once():
    """However large the budget is."""
    why, along, _ = driven(drive_watch(route(1e4, 1e6, turn_back_usvh=200.0)), 1e4)
    assert 'the level is 200' in why
    assert along < LENGTH_M


def test_dose_and_time_of_a_drive_are_added_up_with_what_was_taken_before():
    """What a vehicle takes while it waits for its route counts in the budget of that route."""
    watch = drive_watch(route(1e4, 1e6), 7.0)
    _, _, dose = driven(watch, 1e4)
    assert watch.dose_usv == pytest.approx(7.0 + dose, rel=0.01)
    assert watch.duration_s == pytest.approx(2.0 * LENGTH_M / SPEED_MPS, abs=1.0)
    assert driven(drive_watch(route(1e4, 1.1 * planned_usv(1e4)), 7.0), 1e4)[0]
