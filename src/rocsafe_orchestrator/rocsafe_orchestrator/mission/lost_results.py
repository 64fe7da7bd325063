# SPDX-License-Identifier: Apache-2.0
"""Flights whose result was lost: the state of the vehicle tells that they have ended.

A result is sent once. It is lost if the nodes did not know each other at that moment, for instance
after a computer slept longer than the lease of its participants.
"""

from collections.abc import Iterator

from rocsafe_orchestrator.mission_state.presence import Sighting
from rocsafe_orchestrator.mission_state.request import OrderKind, Status
from rocsafe_orchestrator.mission_state.request_book import RequestBook
from rocsafe_orchestrator.mission_state.situation import Situation

# Wall time after a landing in which the result of the flight is waited for.
RESULT_S = 10.0


class LostResults:
    """Watches the vehicles whose flights have no result yet; `requests` are those of a mission."""

    def __init__(self, requests: RequestBook) -> None:
        self._requests = requests
        self._landed_s: dict[str, float] = {}

    def found(self, now_s: float, situation: Situation) -> Iterator[tuple[str, Sighting]]:
        """Yield vehicles that have stood too long after their route, and what is known of each."""
        for request in self._requests.of_kind(OrderKind.FLY):
            name = request.order.vehicle
            seen = situation.sightings.get(name, Sighting())
            if request.status is not Status.ACCEPTED or seen.visited is None:
                self._landed_s.pop(name, None)
            elif now_s - self._landed_s.setdefault(name, now_s) > RESULT_S:
                yield name, seen
