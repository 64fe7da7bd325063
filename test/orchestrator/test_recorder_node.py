# SPDX-License-Identifier: Apache-2.0
"""The recorder keeps what is published, and a step is done only when it is with the kernel."""

import os
import signal
import subprocess
import sys
from collections import Counter

import pytest
from mcap_ros2.decoder import DecoderFactory

from rocsafe_orchestrator.recording.finalising import finalise

DEADLINE_S = 60.0
STEP_NS = 100_000_000


class Vehicle:
    """A vehicle's and the world's side: publishes fixes and times, hears reports."""

    def __init__(self, ros):
        from rclpy.node import Node

        from rocsafe_ros.interfaces import topics

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


def recorded_counts(directory):
    """Number of recorded messages of each topic."""
    from mcap.reader import make_reader

    with finalise(directory).path.open('rb') as stream:
        summary = make_reader(stream).get_summary()
        counts = summary.statistics.channel_message_counts
        return {channel.topic: counts.get(channel.id, 0)
                for channel in summary.channels.values()}  # fmt: skip


def test_bursts_are_recorded_whole(ros, vehicle, tmp_path):
    """At full speed several messages of a topic come at once: every one is recorded."""
    from rclpy.parameter import Parameter

    from rocsafe_interfaces.msg import AccumulatedDose, Decision, VehicleState
    from rocsafe_orchestrator.recorder_node import RecorderNode
    from rocsafe_ros.interfaces import topics

    recorder = RecorderNode(
        context=ros.context,
        parameter_overrides=[
            Parameter('output_directory', value=str(tmp_path)),
            Parameter('vehicles', value=['rav1']),
        ],
    )
    ros.executor.add_node(recorder)
    doses = topics.create_publisher(vehicle.node, topics.ACCUMULATED_DOSE)
    decisions = topics.create_publisher(vehicle.world, topics.DECISIONS)
    heard = (doses, decisions, vehicle.others[0], vehicle.fixes)
    ros.spin_until(lambda: all(p.get_subscription_count() for p in heard), DEADLINE_S)
    vehicle.step(1)
    written, write = Counter(), recorder._segment.write
    recorder._segment.write = lambda number, *rest: (
        written.update([number]),
        write(number, *rest),
    )
    for number in range(40):
        doses.publish(AccumulatedDose(dose_usv=float(number)))
    for number in range(8):
        vehicle.others[0].publish(VehicleState(vehicle='rav1', viewpoints_visited=number))
        decisions.publish(Decision(text=str(number)))
    vehicle.node.get_logger().warning('something to remember')
    vehicle.step(2)
    ros.spin_until(lambda: sorted(written.values())[-3:] == [8, 8, 40], DEADLINE_S)
    ros.executor.remove_node(recorder)
    recorder.destroy_node()
    counts = recorded_counts(tmp_path)
    assert counts['/rav1/accumulated_dose'] == 40
    assert counts['/rav1/state'] == counts['/decisions'] == 8
    assert counts['/clock'] >= 2
    assert counts['/rosout'] >= 1


def test_every_topic_is_recorded_or_left_out_with_a_reason():
    """A topic that is added is recorded without another line."""
    from rocsafe_orchestrator.recording.recorded_topics import LEFT_OUT, recorded_topics
    from rocsafe_ros.interfaces import topics

    recorded = {spec.name for spec, _ in recorded_topics(['rav1'], (), ['rav1'])}
    assert recorded | set(LEFT_OUT) == {spec.name for spec in topics.TOPICS}
    assert not recorded & set(LEFT_OUT)
    assert all(LEFT_OUT.values())


def start_recorder_node(ros, directory):
    """Return a recorder of one vehicle in this process, outside lock-step."""
    from rclpy.parameter import Parameter

    from rocsafe_orchestrator.recorder_node import RecorderNode

    recorder = RecorderNode(
        context=ros.context,
        parameter_overrides=[
            Parameter('output_directory', value=str(directory)),
            Parameter('vehicles', value=['rav1']),
            Parameter('lock_step', value=False),
        ],
    )
    ros.executor.add_node(recorder)
    return recorder


def has_heard_all(events):
    """Return whether the mission of the test below has been heard."""
    states = [state for state, *_ in events._before.values()]
    counts = [one.count for one in events._heard.values()]
    return len(events._told) >= 3 and states == [6] and counts == [3]


def test_evidence_is_logged_without_any_console(ros, tmp_path):
    """Decision, photograph, product, state and readings: each with the hash of what is recorded.

    A recorder that is started again, and hears it all again, adds nothing twice.
    """
    import hashlib

    from mcap.reader import make_reader
    from rclpy.node import Node

    from rocsafe_geo.evidence.evidence_log import LOG_NAME, read_log
    from rocsafe_interfaces.msg import (
        Decision,
        HazardSourceArray,
        RadiationReading,
        ShotReceipt,
        VehicleState,
    )
    from rocsafe_ros.conversions import stamp_of_ns
    from rocsafe_ros.interfaces import topics

    def reading(second, rate):
        made = RadiationReading(detector='nai', dose_rate_usvh=rate, dose_rate_std_usvh=0.5)
        made.header.stamp = stamp_of_ns(second * 1_000_000_000)
        return made

    sent = [
        (topics.DECISIONS, '', [Decision(by='orchestrator', kind='loss', text='rav2 is lost')]),
        (topics.RECEIPTS, '', [ShotReceipt(vehicle='rav1', shot_id='rav1-0', sha256='ab' * 32)]),
        (topics.HAZARD_SOURCES, '', [HazardSourceArray()]),
        (topics.STATE, 'rav1', [VehicleState(state=number) for number in (4, 4, 6)]),
        (topics.RADIATION, 'rav1', [reading(1, 2.0), reading(2, 9.0), reading(3, 3.0)]),
    ]  # fmt: skip
    (tmp_path / 'run.json').write_text('{"git_revision": "abc"}')
    node = Node('mission', context=ros.context)
    ros.executor.add_node(node)
    publishers = [topics.create_publisher(node, spec, name) for spec, name, _ in sent]
    for publisher, (_, _, messages) in zip(publishers, sent, strict=True):
        for message in messages:
            publisher.publish(message)
    for _ in range(2):
        recorder = start_recorder_node(ros, tmp_path)
        ros.spin_until(lambda r=recorder: has_heard_all(r._events), DEADLINE_S)
        ros.executor.remove_node(recorder)
        recorder.destroy_node()
    ros.executor.remove_node(node)
    node.destroy_node()
    entries = read_log(tmp_path / LOG_NAME)
    assert entries[0]['kind'] == 'run'
    assert entries[0]['git_revision'] == 'abc'
    counts = Counter(entry['kind'] for entry in entries)
    assert [counts[kind] for kind in ('decision', 'photograph', 'product')] == [1, 1, 1]
    found = {entry['kind']: entry for entry in entries}
    assert found['decision']['by'] == 'orchestrator'
    assert found['photograph']['message']['sha256'] == 'ab' * 32
    states = [entry['message']['state'] for entry in entries if entry['kind'] == 'state']
    assert states[:2] == [4, 6]
    told = found['readings']
    assert (told['by'], told['count'], told['highest']['dose_rate_usvh']) == ('rav1', 3, 9.0)
    with finalise(tmp_path).path.open('rb') as stream:
        recorded = {
            hashlib.sha256(message.data).hexdigest()
            for _, channel, message in make_reader(stream).iter_messages()
            if channel.topic == '/decisions'
        }
    assert found['decision']['recorded_sha256'] in recorded
