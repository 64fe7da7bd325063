# SPDX-License-Identifier: Apache-2.0
"""The node ``air`` answers fixes with readings of gas, particles and wind."""

import pytest
import yaml

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import NavSatFix, NavSatStatus

from rocsafe_dispersion.air_node import AirNode
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_ros.conversions import ns_of_stamp, stamp_of_ns
from rocsafe_ros.interfaces import topics
from rocsafe_ros.parameters import ParameterError

DEADLINE_S = 60.0
STEP_NS = 500_000_000
TANKER = GeoPosition(53.28, -9.06, 60.0)
DOWNWIND = offset(TANKER, 30.0, 0.0, 2.0)
# The lamp remembers for 12 s, and the intake delays by 1 s.
STEPS = 60


def fix_at(number, position=DOWNWIND):
    """Return the fix of step `number`."""
    fix = NavSatFix(
        latitude=position.latitude_deg,
        longitude=position.longitude_deg,
        altitude=position.altitude_m,
    )
    fix.status.status = NavSatStatus.STATUS_FIX
    fix.header.stamp = stamp_of_ns(number * STEP_NS)
    return fix


@pytest.fixture
def air_file(tmp_path):
    """Return the settings of a leaking tanker of benzene."""
    file = tmp_path / 'air.yaml'
    place = [TANKER.latitude_deg, TANKER.longitude_deg]
    release = {'name': 'a', 'agent': 'benzene', 'position': place, 'rate_g_s': 50.0}
    content = {
        'wind': {'towards_east_mps': 4.0},
        'releases': [release | {'start_s': -100.0}],
        'gas_sensors': ['pid_10_6_ev'],
        'particle_counter': True,
        'ground_altitude_m': TANKER.altitude_m,
    }
    file.write_text(yaml.safe_dump(content))
    return str(file)


def parameters(**values):
    """Return the parameters of a node."""
    return [Parameter(name, value=value) for name, value in values.items()]


def test_vehicle_downwind_of_a_tanker_reads_its_gas(ros, air_file):
    """With the stamps of whole windows and the believed place; the wind goes east."""
    node = AirNode(
        context=ros.context,
        parameter_overrides=parameters(vehicles=['rav1'], air_file=air_file, lock_step=False),
    )
    drone = Node('drone', context=ros.context)
    publishers = [
        topics.create_publisher(drone, spec, 'rav1')
        for spec in (topics.GROUND_TRUTH_FIX, topics.FIX)
    ]
    gas, bio, wind = [], [], []
    for spec, heard in ((topics.GAS, gas), (topics.BIO, bio), (topics.ANEMOMETER, wind)):
        topics.create_subscription(drone, spec, heard.append, 'rav1')
    for each in (node, drone):
        ros.executor.add_node(each)
    ros.spin_until(
        lambda: (
            all(one.get_subscription_count() for one in publishers)
            and drone.count_publishers('rav1/gas') == 1
        ),
        DEADLINE_S,
    )
    for number in range(1, STEPS + 1):
        for publisher in publishers:
            publisher.publish(fix_at(number))
    ros.spin_until(lambda: len(gas) >= 10 and len(bio) >= 10 and len(wind) >= 10, DEADLINE_S)
    assert all(ns_of_stamp(one.header.stamp) % (2 * STEP_NS) == 0 for one in (*gas, *bio, *wind))
    assert max(one.raw for one in gas) > 1.0
    assert gas[0].unit == 'ppm'
    assert gas[0].calibration_gas == 'isobutylene'
    assert gas[0].position.latitude == pytest.approx(DOWNWIND.latitude_deg)
    assert gas[0].header.frame_id == 'rav1/gas_sensor'
    assert sum(one.towards_east_mps for one in wind) / len(wind) == pytest.approx(2.8, abs=0.8)
    assert bio[0].total > 0
    for each in (node, drone):
        ros.executor.remove_node(each)
        each.destroy_node()


def test_wrong_settings_are_refused_in_one_line(ros, tmp_path):
    """By the name of the file and of the release."""
    file = tmp_path / 'air.yaml'
    file.write_text('releases: [{name: a, agent: water, position: [0, 0], rate_g_s: 1}]')
    with pytest.raises(ParameterError, match='water'):
        AirNode(
            context=ros.context,
            parameter_overrides=parameters(air_file=str(file), lock_step=False),
        )
