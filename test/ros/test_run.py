# SPDX-License-Identifier: Apache-2.0
"""A node's process ends cleanly on both signals, on a wrong parameter and with its supervisor."""

import fcntl
import os
import signal
import subprocess
import sys
import time

import pytest

from rocsafe_ros.process.run import is_orphan

DEADLINE_S = 60.0

NODE = """
import sys
from dataclasses import dataclass, field
from rclpy.node import Node
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.process.run import run

@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    speed_mps: float = field(default=1.0, metadata={'min': 0.5, 'max': 2.0})

class Subject(Node):
    def __init__(self):
        super().__init__('subject')
        declare_options(self, Options)
        self.create_timer(0.05, lambda: print('alive', flush=True))

sys.exit(run(Subject))
"""
# Starts the node, tells its process id and dies without a word to it.
SUPERVISOR = """
import os, subprocess, sys, time
os.environ['ROCSAFE_SUPERVISOR_PID'] = str(os.getpid())
child = subprocess.Popen([sys.executable, '-c', sys.argv[1]], stdout=subprocess.PIPE)
child.stdout.readline()
print(child.pid, flush=True)
time.sleep(60)
"""


def start(code, *args):
    """Start Python on `code` with the test's own import path."""
    path = os.pathsep.join(entry for entry in sys.path if entry)
    return subprocess.Popen(
        [sys.executable, '-c', code, *args],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, 'PYTHONPATH': path},
    )


@pytest.fixture
def child(own_domain):
    """Start the subject node; kill it if the test did not end it."""
    children = []

    def begin(*args):
        children.append(start(NODE, *args))
        return children[-1]

    yield begin
    for process in children:
        process.kill()
        process.communicate(timeout=DEADLINE_S)


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_the_node_without_a_word(child, number):
    """Both signals: exit 0, nothing on standard error."""
    process = child()
    assert process.stdout.readline() == 'alive\n'
    process.send_signal(number)
    _, errors = process.communicate(timeout=DEADLINE_S)
    assert (process.returncode, errors) == (0, '')


def test_a_node_runs_without_standard_streams(own_domain, tmp_path):
    """As under a service manager; libraries fail where there is no standard error."""
    told = tmp_path / 'told'
    code = NODE.replace("print('alive', flush=True)", f"open({str(told)!r}, 'w').close()")
    path = os.pathsep.join(entry for entry in sys.path if entry)
    shell = ['sh', '-c', 'exec "$0" -c "$1" 0<&- >&- 2>&-', sys.executable, code]
    with subprocess.Popen(shell, env={**os.environ, 'PYTHONPATH': path}) as process:
        end_s = time.monotonic() + DEADLINE_S
        while not told.exists() and process.poll() is None and time.monotonic() < end_s:
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        assert process.wait(DEADLINE_S) == 0
    assert told.exists()


@pytest.mark.parametrize(
    ('fault', 'line'),
    [
        ("raise MemoryError('8 GiB')", 'error: not enough memory: 8 GiB'),
        ('raise MemoryError', 'error: not enough memory: MemoryError'),
        # A thread of its own, where the system grants none.
        (
            "threading.Thread.start = refuse; BackgroundJob(print, 'fitting', None)",
            'error: not enough memory: fitting: no thread',
        ),
    ],
)
def test_short_memory_is_one_line_and_a_restart(own_domain, fault, line):
    """No traceback: the supervisor tells the last line, and starts the node again."""
    code = NODE.replace(
        'sys.exit(',
        f"""
import threading
from rocsafe_ros.background_job import BackgroundJob

def refuse(_):
    raise RuntimeError('no thread')

def fail():
    {fault}

def make():
    node = Subject()
    node.create_timer(0.1, fail)
    return node

sys.exit(""",
        1,
    ).replace('run(Subject)', 'run(make)')
    process = start(code)
    _, errors = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 1
    assert 'Traceback' not in errors
    assert errors.splitlines()[-1] == line


def test_wrong_parameter_is_one_line_and_exit_2(child):
    """No traceback for a user's mistake."""
    process = child('--ros-args', '-p', 'speed_mps:=9.0')
    _, errors = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 2
    assert errors == 'error: subject: parameter speed_mps = 9.0 must be within 0.5 to 2.0\n'


def test_misspelt_parameter_in_a_file_is_one_line_and_exit_2(child, tmp_path):
    """ROS ignores it, and the node would run with its default."""
    path = tmp_path / 'config.yaml'
    path.write_text('/**/subject: {ros__parameters: {sped_mps: 1.5}}\n')
    process = child('--ros-args', '--params-file', str(path))
    _, errors = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 2
    assert errors == 'error: subject: no parameter sped_mps (did you mean speed_mps?)\n'


def test_argument_that_ros_ignores_is_refused(child):
    """Otherwise a parameter without --ros-args would silently keep its default."""
    process = child('--speed_mps', '1.5', '--ros-args', '-p', 'speed_mps:=1.5')
    _, errors = process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 2
    assert errors == (
        "error: argument '--speed_mps' is not known: a parameter is set by --ros-args -p "
        'NAME:=VALUE; more: --help\n'
    )


def test_help_says_what_the_node_is_and_starts_nothing():
    """Here a node that is a command of `rocsafe`, too."""
    code = 'import sys; from rocsafe_mavlink.view_node import main; sys.exit(main())'
    text, errors = start(code, '--help').communicate(timeout=DEADLINE_S)
    assert text.startswith('usage: ')
    assert 'The node mavlink_view: shows simulated vehicles to a MAVLink ground station.' in text
    assert '--params-file FILE' in text
    assert errors == ''


@pytest.mark.parametrize('is_supervised', [True, False])
def test_node_that_stood_still_ends_to_be_started_again(own_domain, monkeypatch, is_supervised):
    """The others have given it up; without a supervisor nobody would start it again."""
    if is_supervised:
        monkeypatch.setenv('ROCSAFE_SUPERVISOR_PID', str(os.getpid()))
    process = start(
        'import rocsafe_ros.process.run\nrocsafe_ros.process.run.STOOD_STILL_S = 0.5\n' + NODE
    )
    assert process.stdout.readline() == 'alive\n'
    process.send_signal(signal.SIGSTOP)
    time.sleep(3.0)
    process.send_signal(signal.SIGCONT)
    if is_supervised:
        _, errors = process.communicate(timeout=DEADLINE_S)
        assert process.returncode == 1
        assert errors.startswith('stood still for ')
        return
    for _ in range(40):
        assert process.stdout.readline() == 'alive\n'
    process.send_signal(signal.SIGTERM)
    _, errors = process.communicate(timeout=DEADLINE_S)
    assert (process.returncode, errors) == (0, '')


def test_node_without_a_supervisor_starts_itself_again(own_domain, monkeypatch, tmp_path):
    """Its mission goes on by agents, whose lock tells so."""
    lock = tmp_path / 'agents.lock'
    lock.touch()
    monkeypatch.setenv('ROCSAFE_SUPERVISOR_PID', '1')
    monkeypatch.setenv('ROCSAFE_FLEET_LOCK', str(lock))
    script = tmp_path / 'node'
    code = 'import rocsafe_ros.process.run\nrocsafe_ros.process.run.STOOD_STILL_S = 0.5\n' + NODE
    script.write_text(f'#!{sys.executable}\n{code}')
    script.chmod(0o755)
    with lock.open('rb') as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        process = subprocess.Popen(
            [script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert process.stdout.readline() == 'alive\n'
        process.send_signal(signal.SIGSTOP)
        time.sleep(3.0)
        process.send_signal(signal.SIGCONT)
        assert process.stderr.readline().startswith('stood still for ')
        for _ in range(40):
            assert process.stdout.readline() == 'alive\n'
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=DEADLINE_S)
    assert process.returncode == 0


def test_node_ends_when_its_supervisor_is_killed(own_domain):
    """No orphan is left, even when the supervisor had no chance to say anything."""
    supervisor = start(SUPERVISOR, NODE)
    node_pid = int(supervisor.stdout.readline())
    supervisor.kill()
    supervisor.communicate(timeout=DEADLINE_S)
    end = time.monotonic() + DEADLINE_S
    while _is_running(node_pid):
        assert time.monotonic() < end, f'process {node_pid} is still there'
        time.sleep(0.05)


def test_orphan_is_no_orphan_while_another_supervisor_holds_the_lock(tmp_path, monkeypatch):
    """The one that started a node may die; one that resumes its run takes its place."""
    lock = tmp_path / 'run.lock'
    monkeypatch.setenv('ROCSAFE_SUPERVISOR_PID', '1')
    monkeypatch.setenv('ROCSAFE_SUPERVISOR_LOCK', str(lock))
    assert is_orphan()
    with lock.open('wb') as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert not is_orphan()
    assert is_orphan()


def _is_running(pid):
    """Whether a process lives; a zombie that waits for its parent does not."""
    try:
        with open(f'/proc/{pid}/stat') as stat:  # noqa: PTH123
            return stat.read().rsplit(')', 1)[1].split()[0] != 'Z'
    except FileNotFoundError:
        return False
