# SPDX-License-Identifier: Apache-2.0
"""The ros2 command as a process: how it starts, waits and ends."""

import re
import signal
import subprocess
import sys
import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_ros.domain.discovery import local_participants
from rocsafe_ros2cli.command_node import command_node

DEADLINE_S = 60.0
FLY = 'rocsafe_interfaces/action/FlyRoute'

UDP_TABLE = """\
  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode
  100: 00000000:3750 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0
  101: 00000000:3751 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0
  102: 0100007F:3752 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0
  103: 00000000:3746 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0
  104: 00000000:384A 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 1 2 0
"""


def test_participants_are_counted_by_their_ports():
    """Domain 27: 14160 and 14162 are participants 0 and 1; 14150 is the multicast port."""
    assert local_participants(UDP_TABLE, 27) == 2
    assert local_participants(UDP_TABLE, 28) == 1
    assert local_participants(UDP_TABLE, 26) == 0


def test_another_process_is_found_whenever_it_started(robot, ros2_process):
    """Discovery waits for all participants of this machine."""
    for _ in range(2):
        out, error = ros2_process('node', 'list').communicate(timeout=DEADLINE_S)
        assert (out, error) == ('/rav1/robot\n', '')


@pytest.mark.parametrize(
    ('words', 'first', 'number'),
    [
        (('topic', 'echo', '/rav1/fix'), 'header:', signal.SIGINT),
        (('topic', 'pub', '/none', 'std_msgs/msg/String'), 'publisher: begin', signal.SIGTERM),
        (('service', 'call', '/none', 'std_srvs/srv/Trigger'), 'waiting for ser', signal.SIGINT),
        (('action', 'send_goal', '/none', FLY), 'Waiting for an action', signal.SIGTERM),
    ],
    ids=['echo', 'pub', 'call', 'send_goal'],
)
def test_signals_end_the_command_quietly(robot, ros2_process, words, first, number):
    """No traceback, the status of the real command."""
    process = ros2_process(*words)
    assert process.stdout.readline().startswith(first)
    process.send_signal(number)
    _, error = process.communicate(timeout=DEADLINE_S)
    assert (process.returncode, error) == (int(number), '')


def test_the_rate_of_a_topic_is_measured_until_ctrl_c(robot, ros2_process):
    """The robot publishes at 20 Hz; best effort may lose many on a busy machine."""
    process = ros2_process('topic', 'hz', '/rav1/fix', '--window', '20')
    rate_hz, end = 0.0, time.monotonic() + DEADLINE_S
    # A report after the machine stood still is right, and of another rate.
    while not 2.0 < rate_hz < 40.0:
        assert time.monotonic() < end, rate_hz
        name, _, rate = process.stdout.readline().partition(': ')
        assert name == 'average rate'
        rate_hz = float(rate)
        assert re.fullmatch(
            r'\tmin: \d\.\d{3}s max: \d\.\d{3}s std dev: \d\.\d{5}s window: \d+\n',
            process.stdout.readline(),
        )
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=DEADLINE_S)
    assert (process.returncode, error) == (2, '')


def test_ctrl_c_cancels_the_goal(robot, ros2_process):
    """The server hears of it before the command ends."""
    robot.cancelled.clear()
    process = ros2_process('action', 'send_goal', '-f', '/rav1/fly_route', FLY, '{plan_id: long}')
    for line in process.stdout:
        if line == 'Feedback:\n':
            process.send_signal(signal.SIGINT)
            break
    out, error = process.communicate(timeout=DEADLINE_S)
    assert error == ''
    assert 'Canceling goal...\n' in out
    assert out.endswith('Goal canceled.\n')
    assert robot.cancelled.wait(DEADLINE_S)
    assert process.returncode == 2


class _InterruptedLate:
    """Has its command's Ctrl-C arrive while the interpreter drops it."""

    def __del__(self):
        signal.raise_signal(signal.SIGINT)


def test_a_signal_while_something_is_dropped_is_not_lost(own_domain):
    """An exception in a `__del__` would be printed and forgotten; rclpy's futures have one."""
    with command_node() as holder:
        late = [_InterruptedLate()]
        holder.node.create_timer(0.01, late.clear)
        with pytest.raises(KeyboardInterrupt):
            holder.spin_until(lambda: False, DEADLINE_S)
        assert not late
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)


def test_a_reader_that_goes_away_ends_the_command_quietly(robot, ros2_process):
    """As `ros2 topic echo ... | head -1` does."""
    process = ros2_process('topic', 'echo', '/rav1/fix')
    # On a busy machine it warns first that nobody publishes yet.
    head = ['grep', '--max-count', '1', '^header:']
    subprocess.run(head, stdin=process.stdout, timeout=DEADLINE_S, check=True)
    process.stdout.close()
    assert process.wait(DEADLINE_S) == 141
    assert process.stderr.read() == ''


def test_help_names_every_command_and_verb(ros2):
    """`ros2`, `ros2 topic` and `-h` show what there is, status 0."""
    status, out, _ = ros2()
    assert status == 0
    for name in ('action', 'interface', 'node', 'param', 'pkg', 'run', 'service', 'topic'):
        assert f'\n  {name:9}  ' in out
    assert ros2('topic') == ros2('topic', '-h')
    for verb in ('echo', 'hz', 'info', 'list', 'pub'):
        assert f'\n  {verb:4}  ' in ros2('topic')[1]
    assert '--once' in ros2('topic', 'echo', '--help')[1]


def test_what_only_the_real_command_has_is_refused(ros2):
    """Status 2; what there is instead is named."""
    status, _, error = ros2('launch', 'rocsafe_orchestrator', 'mission.launch.py')
    assert status == 2
    assert "invalid choice: 'launch'" in error


def test_commands_without_a_node_do_not_load_ros():
    """`ros2 run` is not to weigh on the node that it starts."""
    code = (
        'import sys; from rocsafe_ros2cli.cli import main; '
        'main(["run", "none", "none"]); print("rclpy" in sys.modules)'
    )
    path = ':'.join(entry for entry in sys.path if entry)
    done = subprocess.run(
        [sys.executable, '-c', f'import sys; sys.path[:0] = {path.split(":")}; {code}'],
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=True,
    )
    assert done.stdout == 'False\n'


@pytest.mark.parametrize(
    'words',
    [
        ('topic', 'pub', '--once', 'bad//name', 'std_msgs/msg/String'),
        ('topic', 'echo', 'bad//name'),
        ('topic', 'hz', 'bad//name'),
        ('service', 'call', 'bad//name', 'std_srvs/srv/Trigger'),
        ('action', 'send_goal', 'bad//name', FLY),
    ],
)
def test_a_name_that_cannot_be_one_is_refused(robot, ros2, words):
    """By rcl's words, which show the place, and without a traceback."""
    status, out, error = ros2(*words)
    assert (status, out) == (1, '')
    lines = error.splitlines()
    assert lines[0].endswith("name must not contain repeated '/':")
    assert lines[1:] == ["  '/bad//name'", '        ^']


def test_a_wrong_domain_is_refused_in_one_line(ros2_process):
    """What rcl says, less the place in its code."""
    process = ros2_process('topic', 'list', environment={'ROS_DOMAIN_ID': 'abc'})
    out, error = process.communicate(timeout=DEADLINE_S)
    assert (process.returncode, out) == (1, '')
    assert error == 'failed to initialize rcl: ROS_DOMAIN_ID is not an integral number\n'


def test_a_workspace_that_is_not_sourced_is_named(ros2, monkeypatch):
    """Packages are looked for in AMENT_PREFIX_PATH."""
    monkeypatch.delenv('AMENT_PREFIX_PATH')
    error = "Environment variable 'AMENT_PREFIX_PATH' is not set or empty\n"
    assert ros2('pkg', 'executables') == (1, '', error)
