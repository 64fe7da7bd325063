# SPDX-License-Identifier: Apache-2.0
"""Processes are kept running, and certainly ended. Children are small Python programs."""

import os
import re
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.process_table.values import (
    NEVER,
    Launch,
    ProcessEvent,
    ProcessEventKind,
    RestartPolicy,
)
from rocsafe_orchestrator.processes.supervisor import Supervisor, last_line

DEADLINE_S = 60.0
SLEEP = 'import time; time.sleep(60)'
STUBBORN = f'import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); print("up"); {SLEEP}'
# Ignores SIGTERM in a grandchild as well, and ends itself when asked.
PARENT = (
    'import subprocess, sys, time\n'
    f'child = subprocess.Popen([sys.executable, "-uc", {STUBBORN!r}], stdout=subprocess.PIPE)\n'
    'child.stdout.readline()\n'
    'print(child.pid)\n'
    'time.sleep(60)\n'
)
QUICK = RestartPolicy(limit=2, first_pause_s=0.0, longest_pause_s=0.0)

MakeSupervisor = Callable[..., Supervisor]


@pytest.fixture
def supervise(tmp_path: Path) -> Iterator[MakeSupervisor]:
    """Give a function that makes a supervisor of programs by name; all end with the test."""
    made: list[Supervisor] = []

    def make(
        programs: dict[str, str], restart: RestartPolicy = NEVER, is_task: bool = False
    ) -> Supervisor:
        launches = [
            Launch(
                name=name,
                command=(sys.executable, '-u', '-S', '-c', program),
                log=tmp_path / f'{name}.log',
                restart=restart,
                is_task=is_task,
            )
            for name, program in programs.items()
        ]
        made.append(Supervisor(launches))
        return made[-1]

    yield make
    for supervisor in made:
        supervisor.stop(deadline_s=0.0)


def wait_for(condition: Callable[[], object]) -> None:
    """Poll until `condition` is true; fail at the deadline."""
    end = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < end, 'deadline'
        time.sleep(0.01)


def events_until(supervisor: Supervisor, kind: ProcessEventKind) -> list[ProcessEvent]:
    """Poll `supervisor` until something of `kind` happened and return all that happened."""
    events: list[ProcessEvent] = []

    def has_happened() -> bool:
        events.extend(supervisor.poll())
        return any(event.kind is kind for event in events)

    wait_for(has_happened)
    return events


def is_alive(pid: int) -> bool:
    """Return whether a process with this id runs; a zombie does not."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except OSError:
        return False


def test_process_is_restarted_after_kill(supervise: MakeSupervisor) -> None:
    """A process that was killed runs again, with a new id."""
    supervisor = supervise({'node': SLEEP}, QUICK)
    supervisor.start('node')
    first = supervisor.pid_of('node')
    assert first is not None
    os.kill(first, signal.SIGKILL)
    events = events_until(supervisor, ProcessEventKind.RESTARTED)
    assert [event.text for event in events] == ['was ended by SIGKILL', 'started again (1 of 2)']
    assert supervisor.pid_of('node') not in (None, first)
    assert supervisor.restarts == {'node': 1}


def test_restarts_have_a_limit_and_the_last_words_are_told(supervise: MakeSupervisor) -> None:
    """A process that always fails is given up, with the last line of its log."""
    supervisor = supervise({'node': 'raise RuntimeError("no luck")'}, QUICK)
    supervisor.start('node')
    events = events_until(supervisor, ProcessEventKind.GAVE_UP)
    assert events[-1].text == 'ended with exit code 1 after 2 restarts: RuntimeError: no luck'
    assert supervisor.restarts == {'node': 2}
    assert not supervisor.running


@pytest.mark.parametrize(
    ('logged', 'told'),
    [
        ('[ERROR] [1795850394.296] [rav3.rav]: the port is taken', ': the port is taken'),
        ('[INFO] [1795850394.296] [rav3.rav]: led by orchestrator@vm', ''),
    ],
)
def test_last_words_are_a_reason_only_if_they_are_no_information(
    supervise: MakeSupervisor, logged: str, told: str
) -> None:
    """Without what ROS puts before a line; what a node did at last does not say why it ended."""
    supervisor = supervise({'node': f'print({logged!r}); raise SystemExit(1)'}, QUICK)
    supervisor.start('node')
    events = events_until(supervisor, ProcessEventKind.GAVE_UP)
    assert events[-1].text == f'ended with exit code 1 after 2 restarts{told}'


def test_process_that_cannot_be_started_again_is_given_up(
    supervise: MakeSupervisor, tmp_path: Path
) -> None:
    """A restart that the machine refuses is an event like any other end, not an exception."""
    supervisor = supervise({'node': 'pass'}, QUICK)
    supervisor.start('node')
    events_until(supervisor, ProcessEventKind.ENDED)
    (tmp_path / 'node.log').unlink()
    (tmp_path / 'node.log').mkdir()
    events = events_until(supervisor, ProcessEventKind.GAVE_UP)
    assert re.match('is not started again: .*node.log: cannot write a log', events[-1].text)
    assert not supervisor.running


def test_wrong_parameters_are_not_tried_again(supervise: MakeSupervisor) -> None:
    """Exit code 2 says that the parameters are wrong: a restart would not help."""
    supervisor = supervise({'node': 'print("speed = -1"); raise SystemExit(2)'}, QUICK)
    supervisor.start('node')
    events = events_until(supervisor, ProcessEventKind.GAVE_UP)
    assert [event.text for event in events] == ['ended with exit code 2: speed = -1']


def test_node_that_ends_with_0_has_failed(supervise: MakeSupervisor) -> None:
    """A node runs until it is asked to stop: an end of its own accord is no success."""
    supervisor = supervise({'node': 'pass'})
    supervisor.start('node')
    events = events_until(supervisor, ProcessEventKind.GAVE_UP)
    assert [event.text for event in events] == ['ended with exit code 0']


def test_task_that_ends_with_0_is_done(supervise: MakeSupervisor) -> None:
    """A task is done when it ends with code 0."""
    supervisor = supervise({'task': 'pass'}, is_task=True)
    supervisor.start('task')
    events = events_until(supervisor, ProcessEventKind.DONE)
    assert [event.name for event in events] == ['task']


def test_pauses_double_up_to_a_limit() -> None:
    """Back-off: 1, 2, 4, then no longer than 5 s."""
    policy = RestartPolicy(limit=9, first_pause_s=1.0, longest_pause_s=5.0)
    assert [policy.pause_s(restarts) for restarts in range(5)] == [1.0, 2.0, 4.0, 5.0, 5.0]


def test_restart_waits_for_its_pause(tmp_path: Path) -> None:
    """Nothing is started again before the pause is over."""
    now = [0.0]
    policy = RestartPolicy(limit=1, first_pause_s=5.0, longest_pause_s=5.0)
    command = (sys.executable, '-S', '-c', 'pass')
    launch = Launch(name='node', command=command, log=tmp_path / 'node.log', restart=policy)
    supervisor = Supervisor([launch], clock=lambda: now[0])
    supervisor.start('node')
    events_until(supervisor, ProcessEventKind.ENDED)
    now[0] = 4.9
    assert supervisor.poll() == []
    now[0] = 5.0
    assert [event.kind for event in supervisor.poll()] == [ProcessEventKind.RESTARTED]
    supervisor.stop(deadline_s=0.0)


def test_stop_asks_all_before_it_waits(supervise: MakeSupervisor, tmp_path: Path) -> None:
    """Two processes of which neither ends before both are asked end by themselves."""
    program = (
        'import signal, sys, time\n'
        'from pathlib import Path\n'
        'def end(*_):\n'
        f'    folder = Path({str(tmp_path)!r})\n'
        '    (folder / "NAME.asked").touch()\n'
        '    while len(list(folder.glob("*.asked"))) < 2: time.sleep(0.01)\n'
        '    (folder / "NAME.ended").touch()\n'
        '    sys.exit(0)\n'
        'signal.signal(signal.SIGTERM, end)\n'
        'print("up"); time.sleep(60)'
    )
    supervisor = supervise({name: program.replace('NAME', name) for name in 'ab'})
    start_and_wait_for_output(supervisor, 'a', 'b')
    supervisor.stop(deadline_s=DEADLINE_S)
    assert {path.name for path in tmp_path.glob('*.ended')} == {'a.ended', 'b.ended'}
    assert not supervisor.running


def test_process_that_still_imports_ends_without_a_traceback(
    supervise: MakeSupervisor, tmp_path: Path
) -> None:
    """One that was started again a moment ago has not set its handlers yet."""
    supervisor = supervise({'node': f'print("up"); {SLEEP}'})
    start_and_wait_for_output(supervisor, 'node')
    supervisor.stop(deadline_s=DEADLINE_S)
    assert 'Traceback' not in (tmp_path / 'node.log').read_text()


def test_stubborn_process_is_killed_at_the_deadline(supervise: MakeSupervisor) -> None:
    """A process that ignores the request to end does not outlive the deadline."""
    supervisor = supervise({'node': STUBBORN})
    start_and_wait_for_output(supervisor, 'node')
    pid = supervisor.pid_of('node')
    assert pid is not None
    supervisor.stop(deadline_s=0.2)
    assert not is_alive(pid)


def test_hurry_ends_the_wait(supervise: MakeSupervisor) -> None:
    """When the user asks twice nobody waits for the deadline."""
    supervisor = supervise({'node': STUBBORN})
    start_and_wait_for_output(supervisor, 'node')
    begin = time.monotonic()
    supervisor.stop(deadline_s=3600.0, must_hurry=lambda: True)
    assert time.monotonic() - begin < DEADLINE_S
    assert not supervisor.running


@pytest.mark.parametrize('ending', ['stop', 'crash'])
def test_grandchildren_end_with_their_parent(supervise: MakeSupervisor, ending: str) -> None:
    """What a process has started is ended with it, whether it was stopped or killed."""
    supervisor = supervise({'node': PARENT})
    start_and_wait_for_output(supervisor, 'node')
    grandchild = int(last_line(log_of(supervisor, 'node')))
    assert is_alive(grandchild)
    if ending == 'stop':
        supervisor.stop(deadline_s=2.0)
    else:
        os.kill(supervisor.pid_of('node') or 0, signal.SIGKILL)
        events_until(supervisor, ProcessEventKind.GAVE_UP)
    wait_for(lambda: not is_alive(grandchild))


def test_stop_leaves_no_zombie(supervise: MakeSupervisor) -> None:
    """Ended processes are reaped."""
    supervisor = supervise({'node': SLEEP})
    supervisor.start('node')
    pid = supervisor.pid_of('node')
    supervisor.stop()
    assert not Path(f'/proc/{pid}').exists()


def test_stop_cancels_a_restart(supervise: MakeSupervisor) -> None:
    """A process that was about to be started again is not after `stop`."""
    supervisor = supervise({'node': 'pass'}, RestartPolicy(limit=5, first_pause_s=0.0))
    supervisor.start('node')
    events_until(supervisor, ProcessEventKind.ENDED)
    supervisor.stop()
    assert supervisor.poll() == []
    assert not supervisor.running


def test_missing_executable_is_a_setup_error(tmp_path: Path) -> None:
    """What cannot be started is named in one line."""
    launch = Launch(name='node', command=('/no/such/file',), log=tmp_path / 'node.log')
    with pytest.raises(SetupError, match='node: cannot start /no/such/file: No such file'):
        Supervisor([launch]).start('node')


def test_ctrl_c_of_the_terminal_does_not_reach_children(supervise: MakeSupervisor) -> None:
    """Children lead sessions of their own: only the supervisor hears the terminal."""
    supervisor = supervise({'node': SLEEP})
    supervisor.start('node')
    pid = supervisor.pid_of('node')
    assert pid is not None
    assert os.getsid(pid) == pid


def start_and_wait_for_output(supervisor: Supervisor, *names: str) -> None:
    """Start processes and wait until each has written its first line."""
    for name in names:
        supervisor.start(name)
    for name in names:
        wait_for(lambda name=name: last_line(log_of(supervisor, name)))  # type: ignore[misc]


def log_of(supervisor: Supervisor, name: str) -> Path:
    """Return the log file of a process."""
    return supervisor._children[name].launch.log
