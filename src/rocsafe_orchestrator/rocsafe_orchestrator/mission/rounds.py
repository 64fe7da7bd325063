# SPDX-License-Identifier: Apache-2.0
"""Further flights of a mission, to the places where readings are most informative."""

from rocsafe_orchestrator.mission.closing import Closing
from rocsafe_orchestrator.mission.losses import PLANNER
from rocsafe_orchestrator.mission.time_watch import TimeWatch
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.phase_record import PhaseRecord
from rocsafe_orchestrator.mission_state.request import OrderKind, Status
from rocsafe_orchestrator.mission_state.request_book import RequestBook

LOCALIZER = 'localizer'


class Rounds:
    """Asks where to measure next and has it planned, while rounds are left.

    Parameters
    ----------
    record
        Phase and faults of the mission.
    requests
        Open requests of the mission.
    closing
        Follows the last round.
    time
        Watches the simulated time of the mission.
    left
        Largest number of further rounds.

    Attributes
    ----------
    is_further
        Whether the first flight is over and another round has begun.
    """

    def __init__(
        self,
        record: PhaseRecord,
        requests: RequestBook,
        closing: Closing,
        time: TimeWatch,
        left: int,
    ) -> None:
        self.is_further = False
        self._record, self._requests = record, requests
        self._closing, self._time = closing, time
        self._left = left

    def go_on_or_collect(self) -> None:
        """All have landed: ask where to measure next while rounds are left, else collect."""
        if self._left <= 0 or self._record.faults:
            self._closing.begin()
            return
        self._left -= 1
        self._time.begin()
        self.is_further = True
        self._requests.forget()
        self._record.enter(Phase.PLANNING)
        self._requests.add(OrderKind.ADVISE, LOCALIZER)

    def advised(self, place_count: int, text: str) -> None:
        """Note how many further places to measure at, 0 if the evidence suffices, and why."""
        request = self._requests.get(OrderKind.ADVISE)
        is_planning = self._record.phase is Phase.PLANNING
        if request is None or request.status is Status.DONE or not is_planning:
            return
        request.finish()
        if place_count:
            self._record.remarks.append(f'another round to {place_count} places: {text}')
            self._requests.add(OrderKind.PLAN, PLANNER)
        else:
            self.end(f'no further round: {text}')

    def end(self, remark: str) -> None:
        """Fly no further round; say why."""
        self._record.remarks.append(remark)
        self._closing.begin()
