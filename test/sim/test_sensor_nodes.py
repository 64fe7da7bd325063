# SPDX-License-Identifier: Apache-2.0
"""Topics of the sensors of a simulated vehicle, over ROS."""

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from std_srvs.srv import SetBool
from test.sim.node_stand import DEADLINE_S, FRAME, Operator

from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_sim.sensors.earth_field import gravity_mps2, magnetic_field_ut, year_of

SENSORS = (topics.IMU, topics.BAROMETER, topics.MAGNETOMETER, topics.RANGE)


def test_sensors_speak_on_their_topics(
    operator: Operator, world: Any, rav: Any, tmp_path: Path
) -> None:
    """On the ground: units and frames of ROS, and the samples of each step at their own times."""
    path = tmp_path / 'sensors.yaml'
    path.write_text('{imu: {rate_hz: 50}, barometer: {}, magnetometer: {}, range: {}}')
    world('rav1', autostart=False, speed=5.0)
    vehicle = rav(sensors_file=str(path), attitude_std_deg=0.5)
    imu, pressure, field, beam = (operator.listen(spec) for spec in SENSORS)
    operator.wait_until_heard(vehicle, *SENSORS)
    operator.call('world/run', SetBool.Request(data=True))
    operator.ros.spin_until(
        lambda: len(imu) >= 50 and pressure and field and len(beam) > 3, DEADLINE_S
    )
    stamps = [ns_of_stamp(one.header.stamp) for one in imu]
    assert {later - earlier for earlier, later in pairwise(stamps)} == {20_000_000}
    assert imu[0].header.frame_id == pressure[0].header.frame_id == 'rav1/base_link'
    assert imu[0].linear_acceleration.z == pytest.approx(gravity_mps2(FRAME.origin), abs=0.5)
    assert imu[0].orientation_covariance[0] == pytest.approx(math.radians(0.5) ** 2)
    assert abs(imu[0].orientation.w) > 0.99
    assert pressure[0].fluid_pressure == pytest.approx(100_606.0, abs=150.0)
    east, north, up = magnetic_field_ut(FRAME.origin, year_of(stamps[0]))
    measured = field[0].magnetic_field
    assert 1e6 * measured.x == pytest.approx(east, abs=6.0)
    assert 1e6 * measured.y == pytest.approx(north, abs=6.0)
    assert 1e6 * measured.z == pytest.approx(up, abs=6.0)
    assert {one.header.frame_id for one in beam} == {'rav1/range'}
    assert max(one.range for one in beam) < 0.5


def test_without_settings_there_are_no_such_topics(operator: Operator, rav: Any) -> None:
    """Nobody is offered a topic on which nothing comes."""
    vehicle = rav(lock_step=False)
    names = {publisher.topic_name for publisher in vehicle.publishers}
    assert '/rav1/fix' in names
    assert not names & {f'/rav1/{spec.name}' for spec in SENSORS}
