# SPDX-License-Identifier: Apache-2.0
"""`ros2 topic echo`, `hz` and `pub`, word for word as ros2cli 0.32 on the same node."""

import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_ros2cli import topic_echo
from rocsafe_ros2cli.topic_hz import RateMeter

DEADLINE_S = 60.0
COMMAND = ('/rav1/command', 'std_msgs/msg/String')
IMAGE_HEAD = "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: ''\nformat: jpeg\n"
FIX_CSV = '0,0,gps,-2,0,52.5,-1e-07,nan,1.5,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0.0,0\n'


def test_one_message_is_shown_and_the_command_ends(robot, ros2):
    """`--once` prints one block and its separator."""
    status, out, error = ros2('topic', 'echo', '--once', '/rav1/fix')
    assert (status, error) == (0, '')
    assert out.startswith('header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: gps\n')
    assert out.endswith('position_covariance_type: 0\n---\n')


@pytest.mark.parametrize(
    ('words', 'expected'),
    [
        (('/rav1/fix', '--csv'), FIX_CSV),
        (('/rav1/fix', 'sensor_msgs/NavSatFix', '--csv'), FIX_CSV),
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
        (('/rav1/image', '--csv', '-l', '2'), '0,0,,jp...,0,1,...\n'),
    ],
)
def test_a_message_is_shown_as_asked(robot, ros2, words, expected):
    """Fields, commas, cut arrays."""
    assert ros2('topic', 'echo', '--once', *words) == (0, expected, '')


def test_arrays_are_cut_after_128_elements_unless_wanted_whole(robot, ros2):
    """The picture has 200 bytes."""
    _, out, _ = ros2('topic', 'echo', '--once', '/rav1/image')
    assert out.endswith("- 126\n- 127\n- '...'\n---\n")
    _, out, _ = ros2('topic', 'echo', '--once', '/rav1/image', '--full-length', '--flow-style')
    assert out.endswith(', 198, 199]\n---\n')


def test_only_messages_that_meet_the_condition_are_shown(robot, ros2):
    """`--filter` and `--timeout`: no fix is that far north."""
    never = ros2('topic', 'echo', '/rav1/fix', '--filter', 'm.latitude > 60', '--timeout', '0.3')
    assert never == (0, '', '')
    shown = ros2('topic', 'echo', '/rav1/fix', '--filter', 'm.latitude > 50', '--once', '--csv')
    assert shown == (0, FIX_CSV, '')


def test_times_of_messages_are_shown_if_wanted(robot, ros2):
    """`--include-message-info` puts a block before each message."""
    _, out, _ = ros2('topic', 'echo', '--once', '-i', '/rav1/fix')
    assert out.startswith('publication_sequence_number: ')
    assert '\nsource_timestamp: ' in out
    assert '\n---\nheader:\n' in out


def test_latched_messages_are_heard(robot, ros2):
    """The quality of service follows the publisher, unless the user chooses another."""
    status, out, _ = ros2('topic', 'echo', '--once', '/region', '--field', 'name')
    assert (status, out) == (0, 'yard\n---\n')
    volatile = ('--qos-durability', 'volatile', '--timeout', '0.3')
    assert ros2('topic', 'echo', '/region', '--field', 'name', *volatile) == (0, '', '')
    chosen = ('--qos-durability', 'transient_local', '--qos-reliability', 'reliable')
    assert ros2('topic', 'echo', '--once', '/region', '--field', 'name', *chosen)[1] == out


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


def test_every_nth_message_is_printed(robot, ros2):
    """`--print 2`: the even ones."""
    _, out, _ = ros2('topic', 'pub', '-t', '3', '-r', '50', '-p', '2', *COMMAND)
    assert out == "publisher: beginning loop\npublishing #2: std_msgs.msg.String(data='')\n\n"


def test_the_wait_for_subscriptions_has_a_limit_if_wanted(robot, ros2):
    """`--once` waits for one; nobody subscribes."""
    words = ('--once', '--max-wait-time-secs', '0.2', '/none', 'std_msgs/msg/String')
    waiting = 'Waiting for at least 1 matching subscription(s)...\n'
    assert ros2('topic', 'pub', *words) == (
        1,
        waiting,
        'Timed out waiting for subscribers: Expected 1 subcribers but only got 0 subscribers\n',
    )


@pytest.mark.parametrize(
    ('words', 'error'),
    [
        (('std_msgs/msg/None',), 'The passed message type is invalid'),
        (
            ('std_msgs/msg/String', 'text'),
            'The passed value needs to be a dictionary in YAML format',
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


def test_reports_come_once_a_second():
    """Ten seconds at 10 Hz, counted from the second arrival."""
    meter = RateMeter(window=1000)
    reports = [meter.arrive(count * 100_000_000) for count in range(1, 102)]
    assert sum(map(bool, reports)) == 9


def test_a_clock_that_starts_again_resets_the_rate():
    """Time 0 is said so, time that runs backwards is not an interval."""
    meter = RateMeter(window=1000)
    assert [meter.arrive(number) for number in (1, 2, 3)] == ['', '', '']
    assert meter.arrive(0) == 'time has reset, resetting counters'
    assert meter.arrive(0) == ''
    later = [meter.arrive(number) for number in (5, 2_000_000_000, 1_000_000_000)]
    assert later[-1] == ''
    assert meter.arrive(2_000_000_000) == ''
    assert meter.arrive(3_000_000_000).endswith('window: 2')
