# SPDX-License-Identifier: Apache-2.0
"""Commands that look at the workspace: interfaces, packages and their executables."""

import os
import pty
import select
import signal
import sys
import time

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_ros2cli.interfaces import nested_type

DEADLINE_S = 60.0

# Says its arguments, then how it is asked to end; or ends at once as its first argument says.
NODE = """#!{python}
import os, signal, sys, time
def asked(number, frame):
    # Not print: the signal may come while the line below is being printed.
    os.write(1, f'signal {{number}}\\n'.encode())
    os._exit(7)
for one in (signal.SIGINT, signal.SIGTERM):
    signal.signal(one, asked)
print(sys.argv[1:], flush=True)
if sys.argv[1:2] == ['exit']:
    sys.exit(int(sys.argv[2]))
if sys.argv[1:2] == ['kill']:
    os.kill(os.getpid(), int(sys.argv[2]))
time.sleep(60)
"""

DEFINITION = """# A wing.

# Its span.
float64 span   # metres
string<=5 name
uint8 LEFT=1  # port side
uint8[<=3] flaps
geometry_msgs/Point[2] tips  # of the wing
Wing[] more
#
"""

SHOWN_POINT = """\tfloat64 x
\tfloat64 y
\tfloat64 z
"""


@pytest.fixture
def workspace(tmp_path, monkeypatch):
    """Install package `wings` with one message and some executables, before all others."""
    (tmp_path / 'share/ament_index/resource_index/packages').mkdir(parents=True)
    (tmp_path / 'share/ament_index/resource_index/packages/wings').touch()
    (tmp_path / 'share/wings/msg').mkdir(parents=True)
    (tmp_path / 'share/wings/msg/Wing.msg').write_text(DEFINITION.replace('Wing[] more\n', ''))
    for name in ('fly', 'sub/land', 'sub/fly2', '.hidden/land', 'readme.txt'):
        path = tmp_path / 'lib/wings' / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(NODE.format(python=sys.executable))
        path.chmod(0o644 if name.endswith('.txt') else 0o755)
    monkeypatch.setenv('AMENT_PREFIX_PATH', f'{tmp_path}:{os.environ["AMENT_PREFIX_PATH"]}')
    return tmp_path


def test_a_definition_is_shown_with_those_of_its_fields(workspace, ros2):
    """Own comments are kept, nested ones are not, as in the real command."""
    _, out, _ = ros2('interface', 'show', 'wings/msg/Wing')
    head, tail = DEFINITION.replace('Wing[] more\n', '').split('# of the wing\n')
    assert out.startswith(f'{head}# of the wing\n\tfloat64 x\n')
    assert out.endswith(f'{SHOWN_POINT}{tail}')


@pytest.mark.parametrize(
    ('line', 'expected'),
    [
        ('float64 x', None),
        ('string<=5[<=3] names', None),
        ('uint8 LEFT=1', None),
        ('uint8 LEFT = 1', None),
        ('Wing left', 'own/msg/Wing'),
        ('Wing[2] wings # left, right', 'own/msg/Wing'),
        ('other/Wing[<=2] wings', 'other/msg/Wing'),
        ('# Wing left', None),
        ('---', None),
        ('', None),
    ],
)
def test_fields_that_hold_messages_are_told_from_others(line, expected):
    """Types without a package are of the own one."""
    assert nested_type(line, 'own') == expected


@pytest.mark.parametrize(
    ('name', 'error'),
    [
        ('none/msg/Wing', "Unknown package 'none'"),
        ('wings/Wing', "Invalid name 'wings/Wing'. Expected three parts separated by '/'"),
        ('wings//Wing', "Invalid name 'wings//Wing'. Must not contain empty parts"),
        ('wings/../Wing', "Invalid name 'wings/../Wing'. Must not contain '..'"),
        ('wings/msg/None', "Could not find the interface '{0}/share/wings/msg/None.idl'"),
    ],
)
def test_an_interface_that_is_not_there(workspace, ros2, name, error):
    """One line each, status 1."""
    assert ros2('interface', 'show', name) == (1, '', error.format(workspace) + '\n')


def test_our_own_interfaces_can_be_shown(ros2):
    """All of them, in the words of their files."""
    status, out, _ = ros2('interface', 'show', 'rocsafe_interfaces/action/FlyRoute')
    assert status == 0
    assert out.startswith('# Fly a route: take off,')
    assert '\nRoute route\n\tstring vehicle              #\n\tGeoPoint home\n\t\tfloat64' in out
    assert out.count('\n---\n') == 2


def test_executables_of_a_package(workspace, ros2):
    """Those that can be run, folders with a dot not."""
    expected = 'wings fly\nwings fly2\nwings land\n'
    assert ros2('pkg', 'executables', 'wings') == (0, expected, '')
    assert expected in ros2('pkg', 'executables')[1]
    assert ros2('pkg', 'executables', 'none') == (1, '', "Package 'none' not found\n")


@pytest.mark.parametrize(
    ('words', 'status', 'out', 'error'),
    [
        (('wings', 'fly', 'exit', '0'), 0, "['exit', '0']\n", ''),
        (
            ('wings', 'fly', 'exit', '3'),
            3,
            "['exit', '3']\n[ros2run]: Process exited with failure 3\n",
            '',
        ),
        (('wings', 'fly', 'kill', '9'), 137, "['kill', '9']\n[ros2run]: Killed\n", ''),
        (('none', 'fly'), 1, '', "Package 'none' not found\n"),
        (('wings', 'none'), 1, '', 'No executable found\n'),
        (('wings', 'readme.txt'), 1, '', 'No executable found\n'),
    ],
)
def test_run_ends_as_its_node_ends(workspace, ros2_process, words, status, out, error):
    """Arguments reach the node, its exit status comes back."""
    process = ros2_process('run', *words)
    assert process.communicate(timeout=DEADLINE_S) == (out, error)
    assert process.returncode == status


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_run_passes_signals_on(workspace, ros2_process, number):
    """Sent to the command alone, below a shell that ignores Ctrl-C; the node ends it."""
    process = ros2_process(
        'run',
        'wings',
        'fly',
        '--ros-args',
        '-r',
        '__ns:=/rav1',
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
    )
    assert process.stdout.readline() == "['--ros-args', '-r', '__ns:=/rav1']\n"
    process.send_signal(number)
    out, error = process.communicate(timeout=DEADLINE_S)
    assert (out, error) == (
        f'signal {int(number)}\n[ros2run]: Process exited with failure 7\n',
        '',
    )
    assert process.returncode == 7


def test_run_does_not_repeat_what_the_terminal_has_told_the_node(workspace):
    """Ctrl-C in a terminal reaches both: the node hears it once."""
    words = [sys.executable, '-m', 'rocsafe_ros2cli', 'run', 'wings', 'fly']
    path = os.pathsep.join(entry for entry in sys.path if entry)
    child, terminal = pty.fork()
    if child == 0:
        os.execve(sys.executable, words, {**os.environ, 'PYTHONPATH': path})  # noqa: S606
    try:
        shown = read_until(terminal, b'[]')
        os.write(terminal, b'\x03')
        shown += read_until(terminal, b'failure 7')
        _, status = os.waitpid(child, 0)
    finally:
        os.close(terminal)
    assert os.waitstatus_to_exitcode(status) == 7
    assert shown.count(b'signal 2') == 1


def read_until(terminal, wanted):
    """Read what a terminal shows until `wanted` is among it; fail the test at the deadline."""
    shown, end = b'', time.monotonic() + DEADLINE_S
    while wanted not in shown:
        ready, _, _ = select.select([terminal], [], [], max(0.0, end - time.monotonic()))
        assert ready, f'{wanted!r} not shown within {DEADLINE_S} s, but {shown!r}'
        shown += os.read(terminal, 1000)
    return shown
