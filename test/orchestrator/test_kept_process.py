# SPDX-License-Identifier: Apache-2.0
"""A process beside the mission is started again when it dies; the page outlives its mission."""

import os
import pty
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rocsafe_orchestrator.process_table.console_process import KeptProcess

DEADLINE_S = 30.0
SLEEPS = 'import sys, time; open(sys.argv[1], "a").write("x"); time.sleep(60)'
ENDS = 'import sys; open(sys.argv[1], "a").write("x"); sys.exit(int(sys.argv[2]))'

# Stays with the page that is given, and tells that it does not any more.
STAYS = """
import sys
from rocsafe_orchestrator.process_table.console_process import KeptProcess, OperatorsPage
from rocsafe_orchestrator.processes.interrupt import Interrupt
interrupt = Interrupt()
with OperatorsPage(is_wanted=True) as page:
    page._process = KeptProcess(sys.argv[1:])
    page.stay(lambda: interrupt.count > 0)
    print('left', page._process.process.pid, page._process.process.poll(), flush=True)
"""


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


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_the_page_stays_in_a_terminal_until_a_signal(tmp_path, number):
    """Also after it was killed and started again; it is gone at the end."""
    told, (master, terminal) = tmp_path / 'told', pty.openpty()
    words = [sys.executable, '-c', STAYS, sys.executable, '-c', SLEEPS, str(told)]
    process = subprocess.Popen(words, stdin=terminal, stdout=terminal, start_new_session=True)
    os.close(terminal)
    wait_for(told, 1)
    text = b''
    while b'Ctrl-C' not in text:
        text += os.read(master, 1024)
    assert process.poll() is None
    process.send_signal(number)
    assert process.wait(DEADLINE_S) == 0
    while b'\n' not in text.partition(b'left')[2]:
        text += os.read(master, 1024)
    left = text.partition(b'left')[2].split()
    assert left[1] == b'None', 'it ran until the signal'
    with pytest.raises(ProcessLookupError):
        os.kill(int(left[0]), 0)


def test_the_page_stays_for_nobody_without_a_terminal(tmp_path):
    """Nor for one that has ended by itself."""
    words = [sys.executable, '-c', STAYS, sys.executable, '-c', SLEEPS, str(tmp_path / 'told')]
    done = subprocess.run(
        words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=DEADLINE_S
    )
    assert done.stdout.startswith('left')


def test_a_page_that_has_ended_by_itself_keeps_no_terminal(tmp_path):
    """As one whose port is taken."""
    master, terminal = pty.openpty()
    words = [sys.executable, '-c', STAYS, sys.executable, '-c', ENDS, str(tmp_path / 'told'), '2']
    process = subprocess.Popen(words, stdin=terminal, stdout=terminal, start_new_session=True)
    os.close(terminal)
    assert process.wait(DEADLINE_S) == 0
    os.close(master)
