# SPDX-License-Identifier: Apache-2.0
"""Limits of every wait of a mission, seconds of wall time."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from rocsafe_geo.option import option
from rocsafe_orchestrator.mission_state.presence import Lease


def _seconds(default: float, doc: str) -> Any:
    return option(default, doc, 0.1, 86_400.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class OrchestratorOptions:
    """Parameters of the orchestrator: the waits that depend on the machine and the survey.

    Raises
    ------
    ValueError
        Unless each is within 0.1 to 86400 s, and silence comes before loss.
    """

    MOVED_PARAMETERS: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ('plan_timeout_s', 'accept_timeout_s', 'repeat_s', 'collect_timeout_s',
         'report_timeout_s', 'cancel_timeout_s', 'stop_timeout_s'),
        'fixed, see Deadlines in rocsafe_orchestrator/mission/options.py',
    )  # fmt: skip

    start_timeout_s: float = _seconds(180.0, 'all processes must be ready within, s')
    stall_timeout_s: float = _seconds(30.0, 'simulated time may stand still for, s')
    map_timeout_s: float = _seconds(300.0, 'the mosaic must be written within, s')
    silent_after_s: float = _seconds(5.0, 'a vehicle not heard for so long gets no orders, s')
    lost_after_s: float = _seconds(15.0, 'a vehicle not heard for so long is replaced, s')

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if not 0.1 <= value <= 86_400.0:
                raise ValueError(f'{each.name} = {value}: must be within 0.1 to 86400 s')
        if not self.lost_after_s > self.silent_after_s:
            raise ValueError(
                f'lost_after_s = {self.lost_after_s:g}: must be above silent_after_s, '
                f'{self.silent_after_s:g} s'
            )

    def lease(self, slowest_beat_s: float = 0.0) -> Lease:
        """Return the heartbeat lease of a vehicle that reports so seldom at least."""
        return Lease(
            silent_s=self.silent_after_s + slowest_beat_s,
            lost_s=self.lost_after_s + slowest_beat_s,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Deadlines(OrchestratorOptions):
    """Limits of all waits: the parameters, and those that nobody needs to set.

    Attributes
    ----------
    plan_s
        A plan must come within this time, added to the budget of the planner and to
        `plan_vehicle_s`.
    plan_vehicle_s
        Further time to plan for each vehicle: 100 take 50 CPU-s, 300 take 130.
    accept_s
        A request must be accepted within this time.
    repeat_s
        A request that is not accepted is first sent again after this time.
    homecoming_s
        When all routes are flown, vehicles that still return must have landed within this time.
    collect_s
        The next photograph must be stored within this time.
    report_s, cancel_s
        The products of a run must be written within this time; if it was cancelled, its map and
        then its products each within the second.
    stop_s
        A process that does not end within this time after it was asked is killed.
    """

    plan_s: float = 180.0
    plan_vehicle_s: float = 3.0
    accept_s: float = 30.0
    repeat_s: float = 2.0
    homecoming_s: float = 600.0
    collect_s: float = 30.0
    report_s: float = 300.0
    cancel_s: float = 60.0
    stop_s: float = 5.0
