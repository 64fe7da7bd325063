# SPDX-License-Identifier: Apache-2.0
"""One mission at a time in a ROS domain."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.processes.domain_lock import domain_lock

HOLDER = (
    'import sys, time, pathlib\n'
    'from rocsafe_orchestrator.processes.domain_lock import domain_lock\n'
    'with domain_lock("5", "small-1", pathlib.Path(sys.argv[1])):\n'
    '    print("held", flush=True); time.sleep(60)\n'
)


def test_domain_is_held_once_and_given_back(tmp_path: Path) -> None:
    """A second mission is refused while the first runs; another domain is free."""
    with domain_lock('5', 'small-1', tmp_path):
        with domain_lock('6', 'small-2', tmp_path):
            pass
        with (
            pytest.raises(SetupError, match=r'another mission is running.* \(small-1\)'),
            domain_lock('5', 'small-1', tmp_path),
        ):
            pass
    with domain_lock('5', 'small-1', tmp_path):
        pass


def test_killed_mission_does_not_hold_its_domain(tmp_path: Path) -> None:
    """After a `kill -9` the next mission starts at once."""
    command = [sys.executable, '-c', HOLDER, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b'held\n'
        with pytest.raises(SetupError), domain_lock('5', 'small-1', tmp_path):
            pass
        holder.send_signal(signal.SIGKILL)
        holder.wait()
        with domain_lock('5', 'small-1', tmp_path):
            pass


def test_copy_of_a_mission_does_not_hold_its_domain(tmp_path: Path) -> None:
    """A node that began as a copy of the orchestrator may outlive it by a moment."""
    # The copy says so, as soon as it can.
    program = HOLDER.replace('print(', 'os.fork() and time.sleep(60); print(')
    command = [sys.executable, '-c', f'import os; {program}', str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b'held\n'
        holder.send_signal(signal.SIGKILL)
        os.waitid(os.P_PID, holder.pid, os.WEXITED | os.WNOWAIT)
        with domain_lock('5', 'small-1', tmp_path):
            pass
        os.killpg(holder.pid, signal.SIGKILL)


def test_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    """One line, with the path."""
    with (
        pytest.raises(SetupError, match='cannot be opened: No such file'),
        domain_lock('5', 'small-1', tmp_path / 'no'),
    ):
        pass
