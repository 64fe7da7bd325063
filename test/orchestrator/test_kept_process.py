# SPDX-License-Identifier: Apache-2.0
"""A process beside the mission is started again when it dies."""

import signal
import sys
import time
from pathlib import Path

import pytest

from rocsafe_orchestrator.process_table.console_process import KeptProcess

DEADLINE_S = 30.0
SLEEPS = 'import sys, time; open(sys.argv[1], "a").write("x"); time.sleep(60)'
ENDS = 'import sys; open(sys.argv[1], "a").write("x"); sys.exit(int(sys.argv[2]))'


def wait_for(told: Path, count: int) -> None:
    """Wait until so many processes have told that they run."""
    end_s = time.monotonic() + DEADLINE_S
    while not told.exists() or len(told.read_text()) < count:
        assert time.monotonic() < end_s, f'fewer than {count} starts'
        time.sleep(0.01)


def test_it_is_started_again_after_a_kill_and_not_after_its_end(tmp_path):
    """Each time; closed, it stays down."""
    told = tmp_path / 'told'
    kept = KeptProcess([sys.executable, '-c', SLEEPS, str(told)])
    for starts in (1, 2):
        wait_for(told, starts)
        kept.process.send_signal(signal.SIGKILL)
    wait_for(told, 3)
    kept.close()
    assert kept.process.poll() is not None
    assert told.read_text() == 'xxx'


@pytest.mark.parametrize('code', [0, 2])
def test_what_ends_by_itself_or_refuses_its_arguments_is_left(tmp_path, code):
    """It would do so again."""
    told = tmp_path / 'told'
    kept = KeptProcess([sys.executable, '-c', ENDS, str(told), str(code)])
    kept._keeper.join(DEADLINE_S)
    assert not kept._keeper.is_alive()
    assert told.read_text() == 'x'
    kept.close()
