# SPDX-License-Identifier: Apache-2.0
"""The recorder keeps what is published, and a step is done only when it is with the kernel."""

import os
import signal
import subprocess
import sys

import pytest
from mcap_ros2.decoder import DecoderFactory

from rocsafe_orchestrator.recording.finalising import finalise

DEADLINE_S = 60.0
STEP_NS = 100_000_000


class Vehicle:
    """A vehicle's and the world's side: publishes fixes and times, hears reports."""

    def __init__(self, ros):
        from rclpy.node import Node

        from rocsafe_ros import topics

        self.ros = ros
        self.node = Node('rav', namespace='rav1', context=ros.context)
        self.world = Node('world', context=ros.context)
        self.fixes = topics.create_publisher(self.node, topics.FIX)
        self.others = [
            topics.create_publisher(self.node, spec) for spec in (topics.STATE, topics.RADIATION)
        ]
        self.clock = topics.create_publisher(self.world, topics.CLOCK)
        self.reports = []
        topics.create_subscription(self.world, topics.STEP_DONE, self._on_report)
        for node in (self.node, self.world):
            ros.executor.add_node(node)

    def _on_report(self, report):
        from rocsafe_ros.conversions import ns_of_stamp

        self.reports.append(ns_of_stamp(report.step))

    def step(self, number):
        """Publish a fix and the time, as often as it takes until the step is reported done."""
        from rosgraph_msgs.msg import Clock
        from sensor_msgs.msg import NavSatFix

        from rocsafe_ros.conversions import stamp_of_ns

        stamp = stamp_of_ns(number * STEP_NS)
        fix = NavSatFix(latitude=float(number))
        fix.header.stamp = stamp
        self.fixes.publish(fix)
        timer = self.world.create_timer(0.2, lambda: self.clock.publish(Clock(clock=stamp)))
        self.clock.publish(Clock(clock=stamp))
        self.ros.spin_until(lambda: number * STEP_NS in self.reports, DEADLINE_S)
        self.world.destroy_timer(timer)

    def close(self):
        """Take the nodes down."""
        for node in (self.node, self.world):
            self.ros.executor.remove_node(node)
            node.destroy_node()


@pytest.fixture
def vehicle(ros):
    """A vehicle to record."""
    made = Vehicle(ros)
    yield made
    made.close()


def recorded_latitudes(directory):
    """Latitudes of the recorded fixes, in order."""
    from mcap.reader import make_reader

    with finalise(directory).path.open('rb') as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        return [
            decoded.latitude
            for _, _, _, decoded in reader.iter_decoded_messages(topics=['/rav1/fix'])
        ]


def start_recorder(directory, domain_id):
    """Start a recorder as a process of its own."""
    return subprocess.Popen(
        [sys.executable, '-m', 'rocsafe_orchestrator.recorder_node', '--ros-args',
         '-p', f'output_directory:={directory}', '-p', 'vehicles:=[rav1]'],
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path), ROS_DOMAIN_ID=str(domain_id)),
    )  # fmt: skip


def test_node_records_what_is_published(ros, vehicle, tmp_path):
    """A fix published before its time is recorded with it, by the name it has in the fleet."""
    from rclpy.parameter import Parameter

    from rocsafe_orchestrator.recorder_node import RecorderNode

    recorder = RecorderNode(
        context=ros.context,
        parameter_overrides=[
            Parameter('output_directory', value=str(tmp_path)),
            Parameter('vehicles', value=['rav1']),
        ],
    )
    ros.executor.add_node(recorder)
    ros.spin_until(lambda: vehicle.fixes.get_subscription_count() > 0, DEADLINE_S)
    for number in (1, 2, 3):
        vehicle.step(number)
    ros.executor.remove_node(recorder)
    recorder.destroy_node()
    assert recorded_latitudes(tmp_path) == [1.0, 2.0, 3.0]


@pytest.mark.system
def test_killed_recorder_loses_nothing_it_reported_done(ros, tmp_path, ros_domain_id):
    """Steps reported done by a recorder that is killed, and by its successor, are all there."""
    for first in (1, 11):
        # Made anew: a writer takes a killed reader for alive until its lease ends.
        vehicle = Vehicle(ros)
        process = start_recorder(tmp_path, ros_domain_id)
        try:
            ros.spin_until(lambda v=vehicle: v.fixes.get_subscription_count() > 0, DEADLINE_S)
            for number in range(first, first + 10):
                vehicle.step(number)
        finally:
            process.send_signal(signal.SIGKILL)
            process.wait(timeout=DEADLINE_S)
            vehicle.close()
    assert recorded_latitudes(tmp_path) == [float(number) for number in range(1, 21)]
