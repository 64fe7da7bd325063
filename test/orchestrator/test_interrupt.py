# SPDX-License-Identifier: Apache-2.0
"""Being asked to stop, once and several times."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator

import pytest

from rocsafe_orchestrator.processes.interrupt import Interrupt, Interrupted, ended_by_signals


@pytest.fixture(autouse=True)
def _handlers() -> Iterator[None]:
    """Give the old handlers back afterwards."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def interrupt() -> Interrupt:
    """Give an interrupt."""
    return Interrupt()


@pytest.mark.parametrize(
    ('number', 'exit_code', 'text'),
    [
        (signal.SIGINT, 130, 'interrupted by Ctrl-C'),
        (signal.SIGTERM, 143, 'interrupted by SIGTERM'),
        (signal.SIGHUP, 129, 'interrupted by closed terminal'),
    ],
)
def test_signal_has_the_exit_code_of_the_shell(
    interrupt: Interrupt, number: signal.Signals, exit_code: int, text: str
) -> None:
    """128 and the number of the signal, as every shell says it."""
    os.kill(os.getpid(), number)
    assert (interrupt.exit_code, interrupt.text) == (exit_code, text)
    assert not interrupt.is_urgent


def test_third_signal_is_urgent_and_the_first_names_the_exit_code(interrupt: Interrupt) -> None:
    """In whatever phase: a second one, by an impatient hand, costs no map and no report."""
    for number in (signal.SIGINT, signal.SIGTERM):
        os.kill(os.getpid(), number)
        assert not interrupt.is_urgent
    interrupt.is_guarded = True
    os.kill(os.getpid(), signal.SIGINT)
    assert not interrupt.is_urgent
    interrupt.is_guarded = False
    assert interrupt.is_urgent
    assert interrupt.exit_code == 130


def test_closed_terminal_counts_once(interrupt: Interrupt) -> None:
    """Shell and kernel both tell it; the run still makes map and report."""
    for _ in range(5):
        os.kill(os.getpid(), signal.SIGHUP)
    assert interrupt.count == 1


def test_hangup_that_is_ignored_stays_so() -> None:
    """As by `nohup`: the run goes on without its terminal."""
    code = (
        'import os, signal; from rocsafe_orchestrator.processes.interrupt import Interrupt\n'
        'signal.signal(signal.SIGHUP, signal.SIG_IGN)\n'
        'one = Interrupt(); os.kill(os.getpid(), signal.SIGHUP); print(one.count)'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=True)
    assert done.stdout == '0\n'


@pytest.mark.parametrize('count', [1, 2, 3])
def test_command_that_flies_nothing_ends_by_the_first_signal(count: int) -> None:
    """Its way out is not cut short by more of them, and it says what happened."""
    left = []

    def command() -> None:
        with ended_by_signals():
            try:
                os.kill(os.getpid(), signal.SIGTERM)
            finally:
                for _ in range(1, count):
                    os.kill(os.getpid(), signal.SIGINT)
                left.append('cleaned')

    with pytest.raises(Interrupted, match='interrupted by SIGTERM') as caught:
        command()
    os.kill(os.getpid(), signal.SIGINT)
    assert (caught.value.exit_code, left) == (143, ['cleaned'])


def test_command_that_ends_by_itself_gives_the_handlers_back() -> None:
    """Whoever called it has its own."""
    before = signal.getsignal(signal.SIGTERM)
    with ended_by_signals():
        assert signal.getsignal(signal.SIGTERM) is not before
    assert signal.getsignal(signal.SIGTERM) is before


def test_fork_of_a_command_ends_by_a_signal_in_silence() -> None:
    """A pool of workers is ended by SIGTERM: no traceback."""
    with ended_by_signals():
        if not (child := os.fork()):
            os.kill(os.getpid(), signal.SIGTERM)
            os._exit(1)
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGTERM


def test_nothing_happened_yet(interrupt: Interrupt) -> None:
    """Without a signal there is no exit code."""
    assert (interrupt.exit_code, interrupt.text, interrupt.count) == (None, '', 0)
