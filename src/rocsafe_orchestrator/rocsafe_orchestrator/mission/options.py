# SPDX-License-Identifier: Apache-2.0
"""Patience of the orchestrator: parameters of its node."""

from dataclasses import dataclass, field, fields
from typing import Any


def _seconds(default: float, doc: str) -> Any:
    return field(default=default, metadata={'doc': doc, 'min': 0.1, 'max': 86_400.0})


@dataclass(frozen=True, slots=True, kw_only=True)
class OrchestratorOptions:
    """Deadlines of every wait, seconds of wall time."""

    start_timeout_s: float = _seconds(180.0, 'all processes must be ready within, s')
    plan_timeout_s: float = _seconds(180.0, 'a plan must come within, beyond its budget, s')
    accept_timeout_s: float = _seconds(30.0, 'a request must be accepted within, s')
    repeat_s: float = _seconds(2.0, 'an unanswered request is first repeated after, s')
    stall_timeout_s: float = _seconds(30.0, 'simulated time may stand still for, s')
    collect_timeout_s: float = _seconds(30.0, 'the next photograph must be stored within, s')
    map_timeout_s: float = _seconds(300.0, 'the mosaic must be written within, s')
    report_timeout_s: float = _seconds(300.0, 'the products must be written within, s')
    cancel_timeout_s: float = _seconds(15.0, 'the products of a cancelled run within, s')
    stop_timeout_s: float = _seconds(5.0, 'a process may take to end when asked, s')

    def __post_init__(self) -> None:
        for option in fields(self):
            value = getattr(self, option.name)
            if not 0.1 <= value <= 86_400.0:
                raise ValueError(f'{option.name} = {value}: must be within 0.1 to 86400 s')
