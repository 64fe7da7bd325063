# SPDX-License-Identifier: Apache-2.0
"""The phase in which a ground vehicle takes evidence: assess, plan, drive, and plan anew."""

from enum import Enum

from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission.time_watch import WORLD
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.phase_record import PhaseRecord
from rocsafe_orchestrator.mission_state.request import OrderKind, Status
from rocsafe_orchestrator.mission_state.request_book import RequestBook
from rocsafe_orchestrator.mission_state.situation import Situation

ROUTER, LOCALIZER = 'router', 'localizer'
# A drive that is interrupted more often is given up.
MOST_PLANS = 5


class DriveEnd(Enum):
    """Place at which a drive has ended, and what is left to do."""

    AT_HOME = 'at home'
    OUT_WITH_EVIDENCE_LEFT = 'out, evidence left'
    OUT_WITH_ALL = 'out, all evidence taken'


class Driving:
    """Lets the ground vehicle of a mission drive to evidence and back, while time runs.

    Parameters
    ----------
    record
        Phase and faults of the mission.
    requests
        Open requests of the mission.
    deadlines
        Limits of all waits.
    vehicle
        Name of the ground vehicle, and of its process; empty: there is none.
    """

    def __init__(
        self, record: PhaseRecord, requests: RequestBook, deadlines: Deadlines, vehicle: str
    ) -> None:
        self._record, self._requests = record, requests
        self._deadlines, self._vehicle = deadlines, vehicle
        self._plans = 0
        self._is_out = self._is_homeward = self._is_ended = False
        self._step_s: float | None = None

    @property
    def is_waiting(self) -> bool:
        """Whether time stands still by intention: the drive is being planned."""
        drive = self._requests.get(OrderKind.DRIVE, self._vehicle)
        is_under_way = drive is not None and drive.status is not Status.WAITING
        return not is_under_way and not self._is_homeward

    def begin(self) -> None:
        """Begin, or go on to the products if there is no ground vehicle or the survey failed."""
        if self._vehicle and self._record.faults:
            self._record.remarks.append('no drive: the survey is not complete')
        if not self._vehicle or self._record.faults:
            self._record.enter(Phase.REPORTING)
            return
        self._plan()

    def advance(self, now_s: float, situation: Situation) -> None:
        """Send what is due next: the assessment, the plan, the drive, the way home."""
        if self._is_ended or self._is_homeward:
            self._close(now_s, situation)
            return
        if self._requests.all_done(OrderKind.ASSESS):
            self._requests.add(OrderKind.PLAN_DRIVE, ROUTER)
        drive = self._requests.get(OrderKind.DRIVE, self._vehicle)
        if drive is not None and drive.status is Status.ACCEPTED:
            self._requests.add(OrderKind.RUN_CLOCK, WORLD)
        elif self._record.passed_s(now_s) > self._deadlines.plan_s:
            self._record.fault(f'no drive begun within {self._deadlines.plan_s:g} s')
            self.give_up()

    def planned(self) -> None:
        """Note that there is a route: drive it."""
        self._requests.finish(OrderKind.PLAN_DRIVE)
        self._requests.add(OrderKind.DRIVE, self._vehicle, self._vehicle)

    def driven(self, text: str, ending: DriveEnd) -> None:
        """Note that a drive has ended; `text` says why if not as planned."""
        self._requests.finish(OrderKind.DRIVE, self._vehicle)
        self._is_out = ending is not DriveEnd.AT_HOME
        if ending is DriveEnd.OUT_WITH_EVIDENCE_LEFT and self._plans < MOST_PLANS:
            self._record.remarks.append(f'{self._vehicle}: {text}; the rest is planned anew')
            self._plan()
            return
        if ending is DriveEnd.OUT_WITH_ALL:
            text, remark = '', f'{self._vehicle}: {text}; it comes home on its own tracks'
            self._record.remarks.append(remark)
        if text:
            self._record.fault(f'{self._vehicle}: {text}')
        self.give_up()

    def give_up(self) -> None:
        """Let the vehicle come home on its own tracks, if it is out."""
        self._record.enter(Phase.DRIVING)
        if not self._is_out:
            self._is_ended = True
            return
        self._is_homeward = True
        self._requests.add(OrderKind.RETURN, self._vehicle, self._vehicle)
        self._requests.add(OrderKind.RUN_CLOCK, WORLD)

    def _plan(self) -> None:
        self._plans += 1
        # Entering a phase forgets the requests of the one before.
        self._record.enter(Phase.DRIVING)
        self._requests.add(OrderKind.ASSESS, LOCALIZER)

    def _close(self, now_s: float, situation: Situation) -> None:
        """Wait until it is home, and its photographs are stored."""
        is_home = self._is_ended or (
            self._requests.all_done(OrderKind.RETURN) and situation.is_driver_home
        )
        limit_s = self._deadlines.homecoming_s if self._is_homeward else self._deadlines.collect_s
        is_late = self._record.passed_s(now_s) > limit_s
        if is_late and not is_home:
            self._record.fault(f'{self._vehicle}: not home within {limit_s:g} s')
        elif is_late and situation.is_driver_unsettled:
            self._record.fault(f'{self._vehicle}: not all of its photographs are stored')
        if is_late or (is_home and not situation.is_driver_unsettled):
            self._record.enter(Phase.REPORTING)
