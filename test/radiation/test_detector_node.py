# SPDX-License-Identifier: Apache-2.0
"""The node publishes readings of lines, tells silence, and refuses wrong parameters in a line."""

import math
import os
import pty
import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import NavSatFix, NavSatStatus
from std_msgs.msg import UInt8MultiArray

from rocsafe_interfaces.msg import VehicleEvent
from rocsafe_radiation.detector_node import DetectorNode
from rocsafe_ros.conversions import stamp_of_ns
from rocsafe_ros.interfaces import topics
from rocsafe_ros.parameters import ParameterError
from rocsafe_ros.process.health import HealthReporter

DEADLINE_S = 30.0


class Bench:
    """A detector node, the vehicle that carries it, and who listens."""

    def __init__(self, ros, **values):
        self.ros = ros
        self.node = DetectorNode(
            context=ros.context,
            namespace='/rav1',
            parameter_overrides=[Parameter(name, value=value) for name, value in values.items()],
        )
        self.reporter = HealthReporter(self.node)
        self.vehicle = Node('vehicle', context=ros.context)
        self.readings, self.events, self.statuses = [], [], []
        self.fix = topics.create_publisher(self.vehicle, topics.FIX, 'rav1')
        self.bytes = topics.create_publisher(self.vehicle, topics.DETECTOR_BYTES, 'rav1')
        for spec, take, vehicle in (
            (topics.RADIATION, self.readings.append, 'rav1'),
            (topics.EVENTS, self.events.append, 'rav1'),
            (topics.DIAGNOSTICS, lambda message: self.statuses.extend(message.status), ''),
        ):
            topics.create_subscription(self.vehicle, spec, take, vehicle)
        for node in (self.node, self.vehicle):
            ros.executor.add_node(node)
        ros.spin_until(self.fix.get_subscription_count, DEADLINE_S)

    def fly(self):
        """Publish where the vehicle is."""
        fix = NavSatFix(latitude=47.0, longitude=8.0, altitude=500.0)
        fix.status.status = NavSatStatus.STATUS_FIX
        fix.header.stamp = stamp_of_ns(time.time_ns())
        self.fix.publish(fix)

    def close(self):
        """Take the nodes down: what they published would reach the next test."""
        self.reporter.close()
        for node in (self.node, self.vehicle):
            self.ros.executor.remove_node(node)
            node.destroy_node()

    def until(self, condition):
        """Fly until `condition` holds."""

        def flies():
            self.fly()
            return condition()

        self.ros.spin_until(flies, DEADLINE_S)


def test_lines_of_a_serial_port_become_readings(ros):
    """Time, place, detector and what it does not tell; a bad line is named in the diagnostics."""
    master, slave = pty.openpty()
    bench = Bench(ros, serial=os.ttyname(slave), silent_after_s=60.0)

    def is_read():
        os.write(master, b'0.25\nrubbish\n')
        return any(not math.isnan(reading.position.latitude) for reading in bench.readings)

    bench.until(is_read)
    reading = next(r for r in bench.readings if not math.isnan(r.position.latitude))
    assert (reading.dose_rate_usvh, reading.detector) == (0.25, 'dose_rate')
    assert reading.header.frame_id == 'rav1/radiation_sensor'
    assert reading.position.latitude == pytest.approx(47.0)
    assert math.isnan(reading.live_time_s)
    bench.until(lambda: any(status.level == DiagnosticStatus.WARN for status in bench.statuses))
    values = {pair.key: pair.value for pair in bench.statuses[-1].values}
    assert 'bad lines, no number' in values
    assert 'rubbish' in values['last bad line']
    bench.close()
    os.close(master)
    os.close(slave)


def test_bytes_of_a_tunnel_become_readings_and_silence_is_an_event(ros):
    """A dead detector is no proof of absence: error, event; then it is heard again."""
    bench = Bench(ros, tunnel=True, silent_after_s=0.5)
    bench.until(lambda: bench.events and bench.statuses)
    assert bench.events[0].severity == VehicleEvent.ERROR
    assert 'no proof' in bench.events[0].text
    assert bench.statuses[-1].level == DiagnosticStatus.ERROR

    def is_read():
        bench.bytes.publish(UInt8MultiArray(data=b'0.5\n'))
        return bench.readings and bench.events[-1].severity == VehicleEvent.INFO

    bench.until(is_read)
    assert bench.readings[0].dose_rate_usvh == 0.5
    bench.close()


@pytest.mark.parametrize(
    ('values', 'words'),
    [
        ({}, 'must have one of serial, udp and tunnel'),
        ({'udp': '127.0.0.1:1', 'tunnel': True}, 'must have one of'),
        ({'udp': 'nowhere'}, 'must be HOST:PORT'),
        ({'udp': '0.0.0.0:5005'}, 'set allow_lan: true'),
        ({'tunnel': True, 'format': 'none'}, 'must be one of dose_rate'),
        ({'tunnel': True, 'format_file': '/nowhere.yaml'}, 'nowhere.yaml'),
        ({'tunnel': True, 'delay_s': -1.0}, 'delay_s is -1.0 s'),
    ],
)
def test_wrong_parameter_is_one_line(ros, values, words):
    """It names the parameter."""
    given = [Parameter(name, value=value) for name, value in values.items()]
    with pytest.raises(ParameterError, match=words) as refusal:
        DetectorNode(context=ros.context, namespace='/rav1', parameter_overrides=given)
    assert '\n' not in str(refusal.value)
