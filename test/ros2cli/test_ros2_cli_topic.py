# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic echo`, `hz` and `pub`, word for word as ros2cli 0.32 on the same node."""

import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from rocsafe_ros2cli.verbs import topic_echo
from rocsafe_ros2cli.verbs.topic_echo import matched_qos
from rocsafe_ros2cli.verbs.topic_rate import RateMeter

DEADLINE_S = 60.0
COMMAND = ('/rav1/command', 'std_msgs/msg/String')
IMAGE_HEAD = "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\nformat: jpeg\n"


def test_one_message_is_shown_and_the_command_ends(robot, ros2):
    """`--once` prints one block and its separator."""
    status, out, error = ros2('topic', 'echo', '--once', '/rav1/fix')
    assert (status, error) == (0, '')
    assert out.startswith('header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: gps\n')
    assert out.endswith('position_covariance_type: 0\n---\n')


@pytest.mark.parametrize(
    ('words', 'expected'),
    [
        (('/rav1/fix', 'sensor_msgs/NavSatFix', '--field', 'latitude'), '52.5\n---\n'),
        (('/rav1/fix', '--field', 'header.frame_id'), 'gps\n---\n'),
        (('/rav1/fix', '--field', 'status'), 'status: -2\nservice: 0\n---\n'),
        (
            ('/rav1/fix', '--field', 'position_covariance'),
            '[1.5 0.  0.  0.  0.  0.  0.  0.  0. ]\n---\n',
        ),
        (
            ('/rav1/image', '--no-arr'),
            IMAGE_HEAD + "data: '<sequence type: uint8, length: 200>'\n---\n",
        ),
    ],
)
def test_a_message_is_shown_as_asked(robot, ros2, words, expected):
    """One field, or arrays left out."""
    assert ros2('topic', 'echo', '--once', *words) == (0, expected, '')


def test_arrays_are_cut_after_128_elements_unless_wanted_whole(robot, ros2):
    """The picture has 200 bytes."""
    _, out, _ = ros2('topic', 'echo', '--once', '/rav1/image')
    assert out.endswith("- 126\n- 127\n- '...'\n---\n")
    _, out, _ = ros2('topic', 'echo', '--once', '/rav1/image', '--full-length')
    assert out.endswith('- 198\n- 199\n---\n')


def test_latched_messages_are_heard(robot, ros2):
    """The quality of service follows the publisher."""
    answer = ros2('topic', 'echo', '--once', '/region', '--field', 'name')
    assert answer == (0, 'yard\n---\n', '')


def test_all_publishers_are_heard_whatever_they_offer():
    """One that is best effort or volatile decides; without any, as for sensor data."""
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    matched = matched_qos([latched, latched])
    assert matched.reliability is ReliabilityPolicy.RELIABLE
    assert matched.durability is DurabilityPolicy.TRANSIENT_LOCAL
    for offers in ([latched, best_effort], []):
        matched = matched_qos(offers)
        assert matched.reliability is ReliabilityPolicy.BEST_EFFORT
        assert matched.durability is DurabilityPolicy.VOLATILE


def test_a_topic_that_never_comes_is_given_up(robot, ros2, monkeypatch):
    """The real command's words, after a deadline."""
    monkeypatch.setattr(topic_echo, 'OTHERS_LIMIT_S', 0.2)
    assert ros2('topic', 'echo', '/none') == (
        1,
        'WARNING: topic [/none] does not appear to be published yet\n',
        'Could not determine the type for the passed topic\n',
    )


@pytest.mark.parametrize(
    ('words', 'error'),
    [
        (('/none', 'std_msgs/msg/None'), 'The passed message type is invalid'),
        (('/none', 'std_srvs/srv/SetBool'), 'The passed message type is invalid'),
        (('/none', 'std_msgs/msg/String', '--field', '.'), "Invalid field value '.'"),
        (
            ('/rav1/fix', '--field', 'header.none'),
            "Invalid field 'header.none': 'Header' object has no attribute 'none'",
        ),
    ],
)
def test_what_cannot_be_shown_is_refused(robot, ros2, words, error):
    """One line each, status 1."""
    assert ros2('topic', 'echo', '--once', *words) == (1, '', error + '\n')


def test_wrong_numbers_are_refused(ros2):
    """By argparse, status 2."""
    status, _, error = ros2('topic', 'hz', '/rav1/fix', '--window', '0')
    assert status == 2
    assert error.endswith('argument --window/-w: value must be a positive integer\n')


def test_messages_are_published(robot, ros2):
    """`--times` at a rate; the robot hears each."""
    robot.heard.clear()
    status, out, error = ros2('topic', 'pub', '-t', '2', '-r', '50', *COMMAND, 'data: climb')
    assert (status, error) == (0, '')
    assert out == (
        'publisher: beginning loop\n'
        "publishing #1: std_msgs.msg.String(data='climb')\n\n"
        "publishing #2: std_msgs.msg.String(data='climb')\n\n"
    )
    end = time.monotonic() + DEADLINE_S
    while robot.heard != ['climb', 'climb'] and time.monotonic() < end:
        time.sleep(0.01)
    assert robot.heard == ['climb', 'climb']


@pytest.mark.parametrize(
    ('words', 'error'),
    [
        (('std_msgs/msg/None',), 'The passed message type is invalid'),
        (
            ('std_msgs/msg/String', 'text'),
            "Failed to populate field: Value 'text' is expected to be a dictionary but is a str",
        ),
        (
            ('std_msgs/msg/String', 'none: 1'),
            "Failed to populate field: 'String' object has no attribute 'none'",
        ),
        (
            ('std_msgs/msg/UInt8', 'data: 256'),
            "Failed to populate field: The 'data' field must be an unsigned integer in [0, 255]",
        ),
    ],
)
def test_what_cannot_be_published_is_refused(ros2, words, error):
    """One line each, status 1."""
    assert ros2('topic', 'pub', '--once', '/none', *words) == (1, '', error + '\n')


def test_the_rate_is_that_of_the_intervals_in_the_window():
    """0.1 s and 0.3 s in turn: 5 Hz on average, one standard deviation 0.1 s."""
    meter, reports, now_ns = RateMeter(window=4), [], 1_000_000_000
    for interval_s in (0.1, 0.3) * 6:
        now_ns += round(interval_s * 1e9)
        reports.append(meter.arrive(now_ns))
    shown = [report for report in reports if report]
    assert shown == [
        'average rate: 5.000\n\tmin: 0.100s max: 0.300s std dev: 0.10000s window: 4'
    ] * len(shown)
    assert len(shown) == 1
