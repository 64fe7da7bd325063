# SPDX-License-Identifier: Apache-2.0
"""Settings that can be planned but not flown by real vehicles are refused by name."""

from collections.abc import Callable
from pathlib import Path

import pytest

from rocsafe_scenario.scenario_checks import flight_mistakes
from rocsafe_scenario.scenario_file import read_scenario

REAL = {'vehicles[1].link': 'udp://127.0.0.1:14550'}


@pytest.mark.parametrize(
    ('changes', 'begin'),
    [
        ({'vehicles[1].is_open': True}, 'vehicles[1].is_open = True: '),
        ({'vehicles[1].battery_swap_s': 60.0}, 'vehicles[1].battery_swap_s = 60.0: '),
    ],
)
def test_what_a_real_vehicle_does_not_fly_is_named(
    changes: dict[str, object], begin: str, small: Callable[..., Path]
) -> None:
    """Once for the real vehicle, never for simulated ones."""
    (line,) = flight_mistakes(read_scenario(small({**REAL, **changes})))
    assert line.startswith(begin)
    assert flight_mistakes(read_scenario(small(changes))) == []


def test_a_plain_survey_is_flown_by_anybody(small: Callable[..., Path]) -> None:
    """Simulated and real vehicles may share one."""
    assert flight_mistakes(read_scenario(small(REAL))) == []
