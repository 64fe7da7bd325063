# SPDX-License-Identifier: Apache-2.0
"""Messages to and from simulated vehicles: routes, batteries, results, labels."""

import math
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from builtin_interfaces.msg import Time
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header
from test.sim.node_stand import FRAME, HOME_ENU, point, route

from rocsafe_geo.motion.battery import VOLTAGE_V, PowerModel
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import Flight, GasReading, GeoPolygon
from rocsafe_scene.cameras.camera import Truth
from rocsafe_sim.flight.segment import Mode, standing
from rocsafe_sim.messages.conversions import (
    OUTCOMES,
    STATES,
    battery_message,
    result_message,
    route_of,
    waiting_text,
)
from rocsafe_sim.messages.drive_conversions import ppm_of
from rocsafe_sim.messages.picture_conversions import depth_message, labels_message
from rocsafe_sim.vehicle.flight_record import FlightOutcome
from rocsafe_sim.vehicle.snapshot import FlightSummary, VehicleSnapshot

POWER = PowerModel(hover_power_w=252.0, endurance_s=1000.0, top_airspeed_mps=0.0)


def snapshot(mode, power_w=252.0):
    """Return a vehicle with half of its charge."""
    return VehicleSnapshot(
        time_ns=0, pose=standing(HOME_ENU, 0.0), mode=mode, viewpoints_visited=0, shots_taken=0,
        battery_fraction=0.5, power_w=power_w, distance_flown_m=0.0,
    )  # fmt: skip


def test_a_route_keeps_its_places():
    """Places come back to a micrometre; over level ground home is at height 0."""
    converted = route_of(route(count=3), 'plan', FRAME)
    assert converted.plan_id == 'plan'
    assert converted.home_enu == pytest.approx(HOME_ENU, abs=1e-6)
    assert converted.is_level
    assert [w.viewpoint_id for w in converted.waypoints] == [10, 11, 12]
    places = np.array([w.position_enu for w in converted.waypoints])
    assert places == pytest.approx(np.array([(0, 0, 20), (8, 0, 20), (16, 0, 20)]), abs=1e-6)


def test_flights_of_a_route_become_swaps():
    """All flights but the last end in a change of the battery after their viewpoints."""
    message = route(count=5)
    cuts = (0, 2, 3, 5)
    message.flights = [Flight(viewpoints=message.viewpoints[a:b]) for a, b in pairwise(cuts)]
    message.battery_swap_s = 60.0
    converted = route_of(message, 'plan', FRAME)
    assert [swap.after for swap in converted.swaps] == [2, 3]
    assert converted.swap_s == 60.0


def test_zones_are_outlines_in_the_plane():
    """Corners of an exclusion come as east and north."""
    corners = [(0.0, 0.0, 0.0), (30.0, 0.0, 0.0), (30.0, 20.0, 0.0)]
    message = route()
    message.exclusions = [GeoPolygon(points=[point(corner) for corner in corners])]
    (ring,) = route_of(message, 'plan', FRAME).exclusions
    assert np.array(ring) == pytest.approx(np.array(corners)[:, :2], abs=1e-3)


def test_viewpoints_below_the_ground_are_refused():
    """The line names the viewpoint and its height."""
    message = route()
    message.viewpoints[1].position = point((8.0, 0.0, -3.0))
    with pytest.raises(ValueError, match='viewpoint 11 is -3 m above the ground: must be above 0'):
        route_of(message, 'plan', FRAME)


def test_the_battery_is_told_as_rep_147_wants():
    """Current is negative while it discharges; charge and capacity are those of the model."""
    flying = battery_message(snapshot(Mode.FLYING), POWER, Time(), 'rav1')
    assert flying.voltage == pytest.approx(VOLTAGE_V)
    assert flying.current == pytest.approx(-20.0)
    assert flying.capacity == pytest.approx(252.0 * 1000.0 / VOLTAGE_V / 3600.0, rel=1e-6)
    assert flying.charge == pytest.approx(0.5 * flying.capacity)
    assert math.isnan(flying.temperature)
    assert flying.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_DISCHARGING
    landed = battery_message(snapshot(Mode.LANDED, 0.0), POWER, Time(), 'rav1')
    assert landed.current == 0.0
    assert landed.power_supply_status == BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING


def test_every_mode_and_outcome_has_its_message():
    """No vehicle is in a state that cannot be told."""
    assert set(STATES) == set(Mode)
    assert set(OUTCOMES) == set(FlightOutcome)
    summary = FlightSummary(
        outcome=FlightOutcome.BATTERY_LOW, text='battery 20%', viewpoints_visited=3,
        distance_flown_m=120.5, duration_s=60.25,
    )  # fmt: skip
    result = result_message(summary, has_camera=True)
    assert result.outcome == FlyRoute.Result.BATTERY_LOW
    assert (result.viewpoints_visited, result.duration_s) == (3, 60.25)


@pytest.mark.parametrize(
    ('number', 'waits_s', 'text'),
    [
        (0, 0.0, ''),
        (0, 12.4, 'keeps away from others: takes off in 12 s'),
        (2, 59.6, 'gets a new battery: takes off in 60 s'),
        (0, math.inf, 'held on the ground, until it is resumed'),
    ],
)
def test_who_waits_says_why(number, waits_s, text):
    """Before the first flight for the others, before a later one for the battery."""
    assert waiting_text(number, waits_s) == text


def test_depth_and_labels_are_written_row_by_row():
    """Labels beyond 16 bits are the largest; depth is infinite where the sky is."""
    truth = Truth(
        depth_m=np.array([[1.5, np.inf]], np.float32),
        numbers=np.array([[70_000, 3]], np.uint32),
    )
    assert np.frombuffer(labels_message(truth, Header()).data, '<u2').tolist() == [65_535, 3]
    depth = np.frombuffer(depth_message(truth, Header()).data, '<f4')
    assert depth[0] == 1.5
    assert math.isinf(depth[1])


def test_concentration_of_a_reading_is_told_in_ppm_only():
    """What is saturated may show little, and counts as above all."""
    assert ppm_of(GasReading(unit='ppm', raw=3.0)) == 3.0
    assert ppm_of(GasReading(unit='ppm', raw=0.1, saturated=True)) == math.inf
    for unit in ('ppm_m', 'mg_m3'):
        assert math.isnan(ppm_of(GasReading(unit=unit, raw=1e6, saturated=True)))
