# SPDX-License-Identifier: Apache-2.0
"""What is gathered from the nodes' messages."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.mission.status import (
    SETTLE_S,
    FlightState,
    Monitor,
    Pace,
    VehicleStatus,
)
from rocsafe_orchestrator.mission_state.standstill import Standstill

HERE = GeoPosition(53.28, -9.06, 98.0)


@given(st.lists(st.floats(0.0, 1e9), min_size=1))
def test_peak_is_the_highest_of_all_readings(rates: list[float]) -> None:
    """Whatever the order of the readings, the highest is kept; nothing read is no peak."""
    monitor = Monitor(('rav1',))
    for rate in rates:
        monitor.on_dose_rate('rav1', rate, HERE)
    assert (monitor.peak.dose_rate_usvh if monitor.peak else 0.0) == max(rates)


def test_photograph_is_counted_once() -> None:
    """A second receipt for a photograph is no second photograph."""
    monitor = Monitor(('rav1',))
    for shot_id in ('rav1-00000', 'rav1-00001', 'rav1-00000'):
        monitor.on_stored(shot_id)
    assert monitor.images_stored == 2


def test_stored_photograph_is_not_rejected() -> None:
    """A photograph that was damaged on the way and stored at the second try is stored."""
    monitor = Monitor(('rav1',))
    monitor.on_rejected('rav1-00000', 'hash differs')
    monitor.on_stored('rav1-00000')
    monitor.on_rejected('rav1-00000', 'hash differs')
    assert monitor.rejections == {}


def test_flight_time_counts_from_the_first_take_off() -> None:
    """Time on the ground before the flight is not flown."""
    monitor = Monitor(('rav1', 'rav2'))
    assert monitor.flight_time_s == 0.0
    monitor.on_vehicle(VehicleStatus(name='rav1', state=FlightState.DISARMED, time_s=100.0))
    monitor.on_vehicle(VehicleStatus(name='rav2', state=FlightState.TAKING_OFF, time_s=110.0))
    monitor.on_vehicle(VehicleStatus(name='rav1', state=FlightState.FLYING, time_s=125.0))
    assert monitor.flight_time_s == 15.0


def test_a_drive_counts_as_time_under_way() -> None:
    """Or the mission would seem to stand still while the ground vehicle drives."""
    monitor = Monitor(('rav1',), driver='rgv1')
    for second, state in ((100.0, FlightState.TAKING_OFF), (160.0, FlightState.LANDED)):
        monitor.on_vehicle(VehicleStatus(name='rav1', state=state, time_s=second))
    monitor.on_vehicle(VehicleStatus(name='rgv1', state=FlightState.DISARMED, time_s=200.0))
    assert monitor.flight_time_s == 60.0
    monitor.on_vehicle(VehicleStatus(name='rgv1', state=FlightState.FLYING, time_s=230.0))
    monitor.on_vehicle(VehicleStatus(name='rgv1', state=FlightState.LANDED, time_s=250.0))
    monitor.on_vehicle(VehicleStatus(name='rgv1', state=FlightState.LANDED, time_s=300.0))
    assert (monitor.flight_time_s, monitor.time_s) == (150.0, 300.0)


def test_time_after_the_last_landing_is_not_flown() -> None:
    """Real vehicles stand on the ground, or are switched off, while the mosaic is made."""
    monitor = Monitor(('rav1',))
    states = [
        (FlightState.ARMED, 5.0),
        (FlightState.TAKING_OFF, 10.0),
        (FlightState.LANDING, 70.0),
        (FlightState.LANDED, 71.0),
        (FlightState.DISARMED, 300.0),
        (FlightState.LOST, 400.0),
    ]
    for state, time_s in states:
        monitor.on_vehicle(VehicleStatus(name='rav1', state=state, time_s=time_s))
    assert monitor.flight_time_s == 61.0


def test_unknown_vehicle_is_passed_over() -> None:
    """Another fleet in the same domain is not ours."""
    monitor = Monitor(('rav1',))
    monitor.on_vehicle(VehicleStatus(name='stranger', time_s=1e9))
    assert [vehicle.name for vehicle in monitor.vehicles] == ['rav1']
    assert monitor.time_s == 0.0


def test_pace_is_simulated_over_wall_time_of_late() -> None:
    """Only the last seconds count."""
    pace = Pace(window_s=2.0)
    assert math.isnan(pace.factor)
    for wall_s in range(10):
        pace.note(float(wall_s), 5.0 * wall_s)
    for wall_s in range(10, 15):
        pace.note(float(wall_s), 45.0 + 20.0 * (wall_s - 9))
    assert pace.factor == pytest.approx(20.0)
    for wall_s in range(15, 20):
        pace.note(float(wall_s), 145.0)
    assert math.isnan(pace.factor)


def test_standstill_counts_from_the_last_growth() -> None:
    """A value that goes back or stays does not move on; a new reason to wait starts over."""
    standstill = Standstill()
    assert standstill.standing_s(5.0, 10.0) == 0.0
    assert standstill.standing_s(5.0, 12.0) == 2.0
    assert standstill.standing_s(4.0, 13.0) == 3.0
    standstill.restart(13.0)
    assert standstill.standing_s(5.0, 14.0) == 1.0
    assert standstill.standing_s(6.0, 20.0) == 0.0


def visited(name: str, plan_id: str, count: int, of: int) -> VehicleStatus:
    """Return a vehicle in the air."""
    return VehicleStatus(
        name=name, state=FlightState.FLYING, time_s=1e9, plan_id=plan_id,
        viewpoint_count=of, viewpoints_visited=count,
    )  # fmt: skip


def test_waypoints_are_those_of_the_present_plan() -> None:
    """20 of an earlier plan of 59 are none of the 8 of the plan of the rest."""
    monitor = Monitor(('rav1', 'rav2'))
    monitor.begin_plan('first', 59)
    monitor.on_vehicle(visited('rav1', 'first', 12, 30))
    monitor.on_vehicle(visited('rav2', 'first', 8, 29))
    assert (monitor.viewpoints_visited, monitor.viewpoints_planned) == (20, 59)
    monitor.begin_plan('rest', 8)
    assert (monitor.viewpoints_visited, monitor.viewpoints_planned) == (0, 8)
    monitor.on_vehicle(visited('rav1', 'rest', 3, 8))
    assert monitor.viewpoints_visited == 3


def test_pace_knows_no_jump_of_the_clock() -> None:
    """Simulated time begins decades after 1970: that is no speed."""
    monitor, pace = Monitor(('rav1',)), Pace()
    pace.note(0.0, monitor.flight_time_s)
    monitor.on_vehicle(VehicleStatus(name='rav1', state=FlightState.TAKING_OFF, time_s=0.0))
    monitor.on_vehicle(VehicleStatus(name='rav1', state=FlightState.TAKING_OFF, time_s=1.75e9))
    pace.note(3.0, monitor.flight_time_s)
    assert math.isnan(pace.factor)
    monitor.on_vehicle(VehicleStatus(name='rav1', state=FlightState.FLYING, time_s=1.75e9 + 30.0))
    pace.note(6.0, monitor.flight_time_s)
    assert pace.factor <= 10.0


@pytest.mark.parametrize('is_by_request', [True, False])
def test_return_by_request_is_no_loss_before_others_can_return(is_by_request: bool) -> None:
    """An order to all vehicles is not answered with a hold of those that obey a moment later."""
    monitor = Monitor(('rav1',))
    status = VehicleStatus(name='rav1', ending='returned early', is_by_request=is_by_request)
    monitor.on_vehicle(status, wall_s=100.0)
    first = monitor.sighting('rav1', 100.0, 0.0)
    assert (first.ending == '') is is_by_request
    assert (first.taken_by == 'operator') is is_by_request
    assert monitor.sighting('rav1', 100.0 + SETTLE_S, 0.0).ending == 'returned early'


def test_real_vehicle_counts_as_still_though_its_receiver_drifts() -> None:
    """A simulated one must stand."""
    for is_simulated in (True, False):
        status = VehicleStatus(
            name='rav1', state=FlightState.HOLDING, speed_mps=0.3, is_simulated=is_simulated
        )
        assert status.is_still is not is_simulated
