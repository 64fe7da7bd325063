# SPDX-License-Identifier: Apache-2.0
"""Watches whether simulated time runs, and starts it again after a pause.

The world pauses when a vehicle has news: a loss, or a hold that is obeyed.
"""

from rocsafe_orchestrator.mission_state.request import OrderKind
from rocsafe_orchestrator.mission_state.request_book import RequestBook
from rocsafe_orchestrator.mission_state.standstill import Standstill

WORLD = 'world'
# Wall time after which time is started again: when the news are answered, and when nobody answers
# them; and between two attempts.
ANSWERED_S, NOBODY_ANSWERS_S, AGAIN_S = 0.4, 1.0, 0.5


class TimeWatch:
    """Measures for how long simulated time has stood still.

    Parameters
    ----------
    requests
        Requests of the mission.

    Attributes
    ----------
    stalled_s
        Wall time for which time has stood still without being paused by the mission, seconds.
    is_begun
        Whether time has run since `begin`.
    """

    def __init__(self, requests: RequestBook) -> None:
        self.stalled_s = 0.0
        self.is_begun = False
        self._requests = requests
        self._progress = Standstill()
        self._again_s = 0.0

    def begin(self) -> None:
        """Restart the measurement, from any time before."""
        self.stalled_s = 0.0
        self.is_begun = False
        self._progress = Standstill()

    def rest(self, now_s: float) -> None:
        """Note that time stands still by intention until `now_s`."""
        self.stalled_s = 0.0
        self._progress.restart(now_s)

    def look(self, now_s: float, simulated_s: float) -> None:
        """Note the simulated time at a moment."""
        self.is_begun = True
        self.stalled_s = self._progress.standing_s(simulated_s, now_s)

    def run_again(self, now_s: float, *, is_answered: bool) -> None:
        """Start time again if it has stood still for long enough."""
        after_s = ANSWERED_S if is_answered else NOBODY_ANSWERS_S
        if self.stalled_s > after_s and now_s >= self._again_s:
            self._again_s = now_s + AGAIN_S
            self._requests.renew(OrderKind.RUN_CLOCK, WORLD)
