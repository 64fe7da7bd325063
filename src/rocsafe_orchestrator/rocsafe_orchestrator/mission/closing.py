# SPDX-License-Identifier: Apache-2.0
"""The phases after the flights: collect photographs, save the map, write the products."""

from collections.abc import Callable

from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.phase_record import PhaseRecord
from rocsafe_orchestrator.mission_state.request import OrderKind
from rocsafe_orchestrator.mission_state.request_book import RequestBook
from rocsafe_orchestrator.mission_state.situation import Situation
from rocsafe_orchestrator.mission_state.standstill import Standstill

MOSAIC, REPORT = 'mosaic', 'report'


class Closing:
    """Ends a mission; what is not done in time is a fault, and the next phase begins.

    Parameters
    ----------
    record
        Phase and faults of the mission.
    requests
        Open requests of the mission.
    deadlines
        Limits of all waits.
    after_map
        Called when the map is written.

    Attributes
    ----------
    shots
        Number of photographs that the image store must get.
    """

    def __init__(
        self,
        record: PhaseRecord,
        requests: RequestBook,
        deadlines: Deadlines,
        after_map: Callable[[], None],
    ) -> None:
        self.shots = 0
        self._record, self._requests = record, requests
        self._deadlines = deadlines
        self._after_map = after_map
        self._collected = Standstill()

    def begin(self) -> None:
        """Begin to collect the photographs."""
        self._record.enter(Phase.COLLECTING)
        self._collected = Standstill()

    def restarted(self, now_s: float) -> None:
        """Wait anew for photographs after a process was started again."""
        self._collected.restart(now_s)

    def collect(self, now_s: float, situation: Situation) -> None:
        """Wait until all photographs are stored, or none has come for a while."""
        settled = situation.images_stored + situation.images_rejected
        standing_s = self._collected.standing_s(settled, now_s)
        if settled < self.shots and standing_s <= self._deadlines.collect_s:
            return
        if situation.images_stored < self.shots:
            self._record.fault(
                f'only {situation.images_stored} of {self.shots} photographs are stored'
            )
        if not settled and not self.shots:
            # Vehicles without a camera: nothing is missing.
            self._record.remarks.append('no vehicle took photographs: there is no map')
            self._record.enter(Phase.REPORTING)
            return
        self._record.enter(Phase.MAPPING)

    def save_map(self, now_s: float, _situation: Situation) -> None:
        """Wait until the map is written."""
        limit_s = self._deadlines.map_timeout_s
        if self._is_over(OrderKind.SAVE_MOSAIC, MOSAIC, now_s, limit_s, f'{MOSAIC}: not written'):
            self._after_map()

    def write_products(self, now_s: float, _situation: Situation) -> None:
        """Wait until the products are written."""
        what, limit_s = 'the products were not written', self._deadlines.report_s
        if self._is_over(OrderKind.WRITE_PRODUCTS, REPORT, now_s, limit_s, what):
            self._record.enter(self._record.outcome)

    def _is_over(
        self, kind: OrderKind, server: str, now_s: float, limit_s: float, what: str
    ) -> bool:
        """Return whether a request was carried out, or its time is over: a fault."""
        self._requests.add(kind, server)
        limit_s = self._deadlines.cancel_s if self._record.is_cancelled else limit_s
        if self._requests.all_done(kind):
            return True
        if self._record.passed_s(now_s) <= limit_s:
            return False
        self._record.fault(f'{what} within {limit_s:g} s')
        return True
