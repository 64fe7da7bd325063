# SPDX-License-Identifier: Apache-2.0
"""Periodic things come at the right simulated times whatever the step."""

import pytest

from rocsafe_sim.clock.cadence import Cadence, floor_to

MS = 1_000_000


def due_ms(period_ms: int, step_ms: int, start_ms: int = 0, until_ms: int = 3000) -> list[int]:
    """Return the times at which something is due."""
    cadence = Cadence(period_ms * MS)
    times = range(start_ms, until_ms + 1, step_ms)
    return [time for time in times if cadence.is_due(time * MS)]


@pytest.mark.parametrize('step_ms', [50, 100, 200])
def test_step_that_divides_the_period_hits_every_multiple(step_ms: int) -> None:
    """Exactly the multiples, from wherever it starts."""
    assert due_ms(200, step_ms) == list(range(0, 3001, 200))
    assert due_ms(200, step_ms, start_ms=1000) == list(range(1000, 3001, 200))


def test_step_that_does_not_divide_the_period_keeps_the_rate() -> None:
    """The first step after each multiple: ten times in three seconds of 333 ms."""
    assert due_ms(333, 100, start_ms=100) == [400, 700, 1000, 1400, 1700, 2000, 2400, 2700, 3000]


def test_step_longer_than_the_period_is_due_each_time() -> None:
    """Once a step at most."""
    assert due_ms(100, 300, start_ms=300) == list(range(300, 3001, 300))


def test_same_time_is_due_once() -> None:
    """A repeated step publishes nothing again."""
    cadence = Cadence(100)
    assert [cadence.is_due(300), cadence.is_due(300)] == [True, False]


def test_floor() -> None:
    """The multiple at or before."""
    assert [floor_to(time, 100) for time in (0, 99, 100, 250)] == [0, 0, 100, 200]
