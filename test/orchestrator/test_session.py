# SPDX-License-Identifier: Apache-2.0
"""A run writes down its processes so that another supervisor finds them, and no others."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.process_table.values import (
    NEVER,
    Launch,
    ProcessEventKind,
    RestartPolicy,
)
from rocsafe_orchestrator.processes.session import (
    Session,
    adopted,
    read_session,
    start_ticks,
    write_session,
)
from rocsafe_orchestrator.processes.supervisor import Supervisor

from .test_supervisor import events_until, is_alive, wait_for

SLEEP = 'import time; time.sleep(60)'
# Starts a process in a session of its own, tells its id and ends: it is nobody's child then.
PARENT = (
    'import subprocess, sys\n'
    'child = subprocess.Popen([sys.executable, "-S", "-c", sys.argv[1]], start_new_session=True,\n'
    '                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)\n'
    'print(child.pid)\n'
)
EMPTY = Session(mission='run-1', token='ab12')  # noqa: S106


@pytest.fixture
def orphan() -> Iterator[int]:
    """Give the id of a process whose parent has ended."""
    done = subprocess.run(
        [sys.executable, '-c', PARENT, SLEEP], capture_output=True, text=True, check=True
    )
    pid = int(done.stdout)
    yield pid
    if is_alive(pid):
        os.kill(pid, signal.SIGKILL)


def test_session_is_read_as_written_and_is_its_owners(tmp_path: Path) -> None:
    """With every process; nobody else may read the token."""
    path = tmp_path / 'session.json'
    session = replace(EMPTY, config='/x.yaml').with_process('world', os.getpid())
    write_session(path, session)
    assert read_session(path) == session
    assert path.stat().st_mode & 0o077 == 0


@pytest.mark.parametrize('text', ['', '{', '[]', '{"mission": "a"}', '{"processes": {"a": 1}}'])
def test_damaged_session_is_refused_by_one_line(tmp_path: Path, text: str) -> None:
    """The path is named."""
    path = tmp_path / 'session.json'
    path.write_text(text)
    with pytest.raises(SetupError, match=r'session.json: cannot be read: .*$'):
        read_session(path)


def test_only_the_same_process_is_found(orphan: int) -> None:
    """Not one that was given the same id later, and none that has ended."""
    session = EMPTY.with_process('world', orphan)
    assert list(session.living()) == ['world']
    assert adopted(orphan, start_ticks(orphan) - 1) is None
    os.kill(orphan, signal.SIGKILL)
    wait_for(lambda: not is_alive(orphan))
    assert session.living() == {}


def supervisor_of(orphan: int, tmp_path: Path, restart: RestartPolicy = NEVER) -> Supervisor:
    """Return a supervisor that has taken over a process."""
    command = (sys.executable, '-S', '-c', SLEEP)
    launch = Launch(name='world', command=command, log=tmp_path / 'log', restart=restart)
    supervisor = Supervisor([launch])
    found = adopted(orphan, start_ticks(orphan))
    assert found is not None
    supervisor.adopt('world', found)
    return supervisor


def test_process_that_was_taken_over_is_stopped(orphan: int, tmp_path: Path) -> None:
    """It is no child, yet it is asked to end, and the supervisor waits for it."""
    supervisor = supervisor_of(orphan, tmp_path)
    supervisor.start('world')
    assert supervisor.pid_of('world') == orphan
    supervisor.stop()
    assert not is_alive(orphan)
    assert not supervisor.running


def test_process_that_was_taken_over_is_started_again(orphan: int, tmp_path: Path) -> None:
    """As any other that is killed; what is started is told."""
    policy = RestartPolicy(limit=1, first_pause_s=0.0, longest_pause_s=0.0)
    supervisor = supervisor_of(orphan, tmp_path, policy)
    assert supervisor.poll() == []
    os.kill(orphan, signal.SIGKILL)
    events = events_until(supervisor, ProcessEventKind.RESTARTED)
    assert [event.text for event in events] == ['ended', 'started again (1 of 1)']
    assert supervisor.pid_of('world') not in (None, orphan)
    supervisor.stop(deadline_s=0.0)
