# SPDX-License-Identifier: Apache-2.0
"""Being asked to stop, once and twice."""

import os
import signal
from collections.abc import Iterator

import pytest

from rocsafe_orchestrator.processes.interrupt import Interrupt


@pytest.fixture
def interrupt() -> Iterator[Interrupt]:
    """Give an interrupt, and the old handlers back afterwards."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.getsignal(number) for number in numbers}
    yield Interrupt()
    for number, handler in before.items():
        signal.signal(number, handler)


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


def test_second_signal_is_urgent_and_the_first_names_the_exit_code(interrupt: Interrupt) -> None:
    """Ctrl-C twice ends at once, with the code of the first."""
    os.kill(os.getpid(), signal.SIGINT)
    os.kill(os.getpid(), signal.SIGTERM)
    assert interrupt.is_urgent
    assert interrupt.exit_code == 130


def test_map_and_products_outlast_a_second_signal(interrupt: Interrupt) -> None:
    """While they are made it takes a third; one in flight counts."""
    os.kill(os.getpid(), signal.SIGINT)
    interrupt.is_saving = True
    os.kill(os.getpid(), signal.SIGINT)
    assert not interrupt.is_urgent
    os.kill(os.getpid(), signal.SIGINT)
    assert interrupt.is_urgent


def test_nothing_happened_yet(interrupt: Interrupt) -> None:
    """Without a signal there is no exit code."""
    assert (interrupt.exit_code, interrupt.text, interrupt.count) == (None, '', 0)
