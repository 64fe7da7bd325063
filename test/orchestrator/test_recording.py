# SPDX-License-Identifier: Apache-2.0
"""A recording survives the death of its recorder and is read by public readers."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.reader import make_reader

from rocsafe_orchestrator.recording.finalising import finalise
from rocsafe_orchestrator.recording.message_definitions import MessageDefinitions
from rocsafe_orchestrator.recording.segments import Channel, SegmentWriter, segments, stamp_ns

SECOND = 1_000_000_000
FIX = Channel(topic='/rav1/fix', message_type='sensor_msgs/msg/NavSatFix')
PLAN = Channel(
    topic='/plan', message_type='rocsafe_interfaces/msg/SurveyPlan', depth=1, is_latched=True
)


@pytest.fixture(scope='module')
def definitions():
    """The message definitions of this environment."""
    pytest.importorskip('rocsafe_interfaces', reason='no ROS 2 here: source it or run make setup')
    return MessageDefinitions.of_environment()


def fix_bytes(seconds, latitude_deg=53.28):
    """A serialised fix stamped `seconds`."""
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import NavSatFix

    message = NavSatFix(latitude=latitude_deg)
    message.header.stamp.sec = seconds
    message.header.frame_id = 'rav1/gps'
    return serialize_message(message)


def write_segment(directory, definitions, messages, *, closed=True):
    """Record serialised fixes, each at its stamp, and return the segment's path."""
    writer = SegmentWriter(directory, definitions)
    number = writer.add_channel(FIX)
    for data in messages:
        writer.write(number, data, stamp_ns(data))
    writer.flush()
    if closed:
        writer.close()
    return writer.path


def log_times_s(path):
    """Log times of all messages, in file order, as a public reader gives them."""
    with path.open('rb') as stream:
        return [m.log_time / SECOND for _, _, m in make_reader(stream).iter_messages()]


def test_segments_are_numbered_on(tmp_path, definitions):
    """A restarted recorder opens the next file, beyond ten too."""
    paths = [write_segment(tmp_path, definitions, []) for _ in range(11)]
    assert [path.name for path in paths[-2:]] == ['mission.part-9.mcap', 'mission.part-10.mcap']
    assert segments(tmp_path) == paths


def test_finalised_recording_is_in_time_order_without_repeats(tmp_path, definitions):
    """What a restarted node publishes again is recorded once; the segments go."""
    write_segment(tmp_path, definitions, [fix_bytes(1), fix_bytes(3)])
    write_segment(tmp_path, definitions, [fix_bytes(2), fix_bytes(3), fix_bytes(4)])
    made = finalise(tmp_path)
    assert log_times_s(made.path) == [1, 2, 3, 4]
    assert (made.segment_count, made.duplicate_count, made.torn_bytes) == (2, 1, 0)
    assert segments(tmp_path) == []


def test_topics_without_messages_leave_no_trace(tmp_path, definitions):
    """A viewer lists what there is, not what might have been."""
    writer = SegmentWriter(tmp_path, definitions)
    writer.write(writer.add_channel(FIX), fix_bytes(1), SECOND)
    writer.add_channel(PLAN)
    writer.close()
    with finalise(tmp_path).path.open('rb') as stream:
        channels = make_reader(stream).get_summary().channels
    assert [channel.topic for channel in channels.values()] == ['/rav1/fix']


def test_same_stamp_with_other_content_is_kept(tmp_path, definitions):
    """Only equal bytes are a repeat."""
    write_segment(tmp_path, definitions, [fix_bytes(1), fix_bytes(1, latitude_deg=53.0)])
    assert finalise(tmp_path).message_count == 2


@pytest.mark.parametrize('lost_bytes', [1, 20, 90])
def test_torn_segment_loses_only_its_last_record(tmp_path, definitions, lost_bytes):
    """A file cut anywhere in its last record gives all records before it."""
    path = write_segment(tmp_path, definitions, [fix_bytes(1), fix_bytes(2)], closed=False)
    os.truncate(path, path.stat().st_size - lost_bytes)
    made = finalise(tmp_path)
    assert log_times_s(made.path) == [1]
    assert made.torn_bytes > 0


def test_empty_segment_makes_an_empty_recording(tmp_path, definitions):
    """A recorder killed at birth does no harm."""
    (tmp_path / 'mission.part-0.mcap').touch()
    assert finalise(tmp_path).message_count == 0


def test_finalising_again_loses_and_doubles_nothing(tmp_path, definitions):
    """Cut off between writing the recording and removing the segments, it is repeated."""
    first = write_segment(tmp_path, definitions, [fix_bytes(1), fix_bytes(2)])
    second = write_segment(tmp_path, definitions, [fix_bytes(3)])
    kept = second.read_bytes()
    finalise(tmp_path)
    second.write_bytes(kept)
    made = finalise(tmp_path)
    assert log_times_s(made.path) == [1, 2, 3]
    assert not first.exists()
    assert finalise(tmp_path) is None


def test_log_time_is_never_before_the_stamp(tmp_path, definitions):
    """Messages of a step may arrive before its time; then the stamp counts."""
    writer = SegmentWriter(tmp_path, definitions)
    number = writer.add_channel(FIX)
    writer.write(number, fix_bytes(10), 9_900_000_000)
    writer.write(number, fix_bytes(11), 12 * SECOND)
    writer.write(number, fix_bytes(99), 13 * SECOND)
    writer.close()
    assert log_times_s(finalise(tmp_path).path) == [10, 12, 13]


def test_flushed_messages_survive_sigkill(tmp_path, definitions):
    """Nothing that was flushed is lost when the process is killed."""
    script = (
        'import sys, os, signal; sys.path.insert(0, sys.argv[2]);'
        'from pathlib import Path;'
        'from test_recording import *;'
        'write_segment(Path(sys.argv[1]), MessageDefinitions.of_environment(),'
        ' [fix_bytes(n) for n in range(1, 501)], closed=False);'
        'os.kill(os.getpid(), signal.SIGKILL)'
    )
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path))
    process = subprocess.run(
        [sys.executable, '-c', script, str(tmp_path), str(Path(__file__).parent)],
        env=environment, timeout=60, check=False,
    )  # fmt: skip
    assert process.returncode == -signal.SIGKILL
    assert finalise(tmp_path).message_count == 500


def test_public_readers_decode_every_message(tmp_path, definitions):
    """Two independent readers agree with what was published, our own types included."""
    rosbags = pytest.importorskip('rosbags.highlevel')
    from mcap_ros2.reader import read_ros2_messages
    from rclpy.serialization import serialize_message

    from rocsafe_interfaces.msg import GeoPoint, Route, SurveyPlan, Viewpoint

    viewpoints = [Viewpoint(id=7, position=GeoPoint(latitude=53.28), yaw_rad=1.5)]
    plan = SurveyPlan(plan_id='p1', routes=[Route(vehicle='rav1', viewpoints=viewpoints)])
    writer = SegmentWriter(tmp_path, definitions)
    writer.write(writer.add_channel(FIX), fix_bytes(1), SECOND)
    writer.write(writer.add_channel(PLAN), serialize_message(plan), 2 * SECOND)
    writer.close()
    path = finalise(tmp_path).path

    decoded = {m.channel.topic: m.ros_msg for m in read_ros2_messages(str(path))}
    assert decoded['/rav1/fix'].latitude == 53.28
    assert decoded['/plan'].routes[0].viewpoints[0].yaw_rad == 1.5
    with rosbags.AnyReader([path]) as reader:
        read = {c.topic: reader.deserialize(raw, c.msgtype) for c, _, raw in reader.messages()}
        offered = {c.topic: c.ext.offered_qos_profiles[0] for c in reader.connections}
    assert read['/plan'].routes[0].viewpoints[0].id == 7
    assert read['/rav1/fix'].header.frame_id == 'rav1/gps'
    assert offered['/plan'].durability.name == 'TRANSIENT_LOCAL'
    assert offered['/rav1/fix'].reliability.name == 'RELIABLE'


def test_attachments_travel_inside_the_recording(tmp_path, definitions):
    """A recording says by itself what was flown; files that are missing are left out."""
    write_segment(tmp_path, definitions, [fix_bytes(1)])
    (tmp_path / 'scenario.yaml').write_text('name: x\n', encoding='utf-8')
    made = finalise(tmp_path, [tmp_path / 'scenario.yaml', tmp_path / 'missing.json'])
    with made.path.open('rb') as stream:
        attached = list(make_reader(stream).iter_attachments())
    assert [(a.name, a.data) for a in attached] == [('scenario.yaml', b'name: x\n')]


@pytest.mark.parametrize(
    ('change', 'named'),
    [
        ({'topic': 'fix'}, 'topic'),
        ({'message_type': 'Fix'}, 'message_type'),
        ({'depth': 0}, 'depth'),
    ],
)
def test_bad_channel_is_refused(change, named):
    """The error names the argument."""
    values = {'topic': '/a', 'message_type': 'a/msg/B', 'depth': 1}
    with pytest.raises(ValueError, match=named):
        Channel(**{**values, **change})
