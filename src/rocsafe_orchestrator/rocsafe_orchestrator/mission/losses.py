# SPDX-License-Identifier: Apache-2.0
"""Vehicles lost in flight, and how the others take over their viewpoints.

The others hold, simulated time is paused and the rest of the survey is planned for them. Then
they fly the new plan.
"""

from collections.abc import Iterable

from rocsafe_orchestrator.mission.request import OrderKind, Status
from rocsafe_orchestrator.mission.request_book import RequestBook
from rocsafe_orchestrator.mission.situation import Crew, Situation

PLANNER, WORLD = 'planner', 'world'


class Losses:
    """Keeps the lost vehicles and makes the requests that replace them.

    Parameters
    ----------
    crew
        Who takes part.
    requests
        Requests of the mission.
    is_replaced
        Whether other vehicles take over.
    """

    def __init__(self, crew: Crew, requests: RequestBook, *, is_replaced: bool) -> None:
        self.lost: dict[str, str] = {}
        self.is_gathering = False
        self._crew = crew
        self._requests = requests
        self._is_replaced = is_replaced
        self._flying: list[str] = []
        self._gone: list[str] = []

    @property
    def others(self) -> list[str]:
        """Vehicles that are not lost."""
        return [name for name in self._crew.vehicle_processes if name not in self.lost]

    def of_process(self, process: str) -> list[str]:
        """Return the vehicles that a process runs."""
        processes = self._crew.vehicle_processes
        return [name for name, lives_in in processes.items() if lives_in == process]

    def note(self, vehicles: Iterable[str], why: str, *, is_gone: bool) -> bool:
        """Note that vehicles are lost and let the others hold; return whether there are others.

        `is_gone`: they are no longer heard, and simulated time must not wait for them.
        """
        self.lost.update(dict.fromkeys(vehicles, why))
        if not self._is_replaced or not self.others:
            return False
        if is_gone:
            self._gone += [name for name in vehicles if name not in self._gone]
        self._gather()
        return True

    def dismiss_again(self) -> None:
        """Tell a restarted world which vehicles it must not wait for."""
        for name in self._gone:
            self._requests.renew(OrderKind.DISMISS, WORLD, name)

    def advance(self, situation: Situation) -> None:
        """Make the next request: hold, pause time, plan the rest."""
        if not self._requests.all_done(OrderKind.HOLD) and self._flying:
            return
        if not set(self.others) <= situation.still:
            return
        self._requests.add(OrderKind.PAUSE_CLOCK, WORLD)
        if self._requests.all_done(OrderKind.PAUSE_CLOCK):
            self._requests.add(OrderKind.PLAN, PLANNER)

    def go_on(self, routed: Iterable[str] | None = None) -> None:
        """Let vehicles fly the new plan; without one, those in flight continue the old plan."""
        self.is_gathering = False
        self._requests.forget()
        self.dismiss_again()
        for name in self._flying if routed is None else routed:
            if name not in self.lost:
                self._requests.add(OrderKind.FLY, self._crew.vehicle_processes[name], name)

    def _gather(self) -> None:
        flying = {
            request.order.vehicle
            for request in self._requests.of_kind(OrderKind.FLY)
            if request.status is not Status.DONE
        }
        known = flying | (set(self._flying) if self.is_gathering else set())
        self._flying = [name for name in self.others if name in known]
        self.is_gathering = True
        self._requests.forget()
        self.dismiss_again()
        for name in self._flying:
            self._requests.add(OrderKind.HOLD, self._crew.vehicle_processes[name], name)
