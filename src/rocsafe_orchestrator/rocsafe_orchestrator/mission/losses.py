# SPDX-License-Identifier: Apache-2.0
"""Vehicles that a mission loses, and how the others take over their viewpoints.

The others hold, simulated time is paused and the rest of the survey is planned for them. Then
they fly the new plan. A vehicle that comes back holds until what it did is merged into the next
plan, which gives it new work, or it returns home.
"""

from collections.abc import Callable, Container, Iterable, Mapping

from rocsafe_orchestrator.mission_state.presence import Lease, Member, Presence, Sighting
from rocsafe_orchestrator.mission_state.request import OrderKind, Status
from rocsafe_orchestrator.mission_state.request_book import RequestBook
from rocsafe_orchestrator.mission_state.situation import Crew, Situation

PLANNER, WORLD = 'planner', 'world'
# A vehicle that came back, or was lost and is heard, hands over its photographs within this time,
# seconds.
MERGE_S = 20.0


class Losses:
    """Keeps the presence of each vehicle and makes the requests that replace the lost ones.

    Parameters
    ----------
    crew
        Who takes part.
    requests
        Requests of the mission.
    lease
        Heartbeat lease of each vehicle.
    is_replaced
        Whether other vehicles take over.
    """

    def __init__(
        self, crew: Crew, requests: RequestBook, lease: Lease, *, is_replaced: bool
    ) -> None:
        self.lost: dict[str, str] = {}
        self.is_gathering = False
        self._members = {name: Member() for name in crew.vehicle_processes}
        self._crew = crew
        self._requests = requests
        self._lease = lease
        self._is_replaced = is_replaced
        self._flying: list[str] = []
        self._gone: list[str] = []
        self._gathers_since_s: float | None = None

    @property
    def others(self) -> list[str]:
        """Vehicles that can be given a route."""
        return [name for name, member in self._members.items() if member.takes_orders]

    @property
    def unheard(self) -> list[str]:
        """Vehicles that may be in the air where this mission does not know: in no plan of it.

        Nothing is heard of them, or somebody else has them.
        """
        return [
            name
            for name, one in self._members.items()
            if (one.presence is Presence.LOST and name in self._gone)
            or (one.presence is Presence.APART and not one.is_withdrawn)
        ]

    @property
    def lets_time_run(self) -> bool:
        """Whether vehicles were commanded to hold and need time to stop."""
        return self._requests.all_done(OrderKind.HOLD) and not self.is_paused

    @property
    def is_paused(self) -> bool:
        """Whether simulated time is paused, or about to be."""
        return self._requests.get(OrderKind.PAUSE_CLOCK) is not None

    def replace_losses(self) -> None:
        """Let other vehicles take over from now on."""
        self._is_replaced = True

    def member(self, vehicle: str) -> Member:
        """Return the presence of a vehicle."""
        return self._members[vehicle]

    def of_process(self, process: str) -> list[str]:
        """Return the vehicles that a process runs."""
        processes = self._crew.vehicle_processes
        return [name for name, lives_in in processes.items() if lives_in == process]

    def process_of(self, vehicle: str) -> str:
        """Return the process that runs a vehicle."""
        return self._crew.vehicle_processes[vehicle]

    def silences_s(
        self, stalled_s: float, waiting_for: Container[str], heard_ago_s: Callable[[str], float]
    ) -> dict[str, float]:
        """Return for how long each vehicle has been silent, seconds of wall time.

        A vehicle in lock-step reports by simulated time: it is silent only while time stands still
        and waits for its process.

        Parameters
        ----------
        stalled_s
            Time for which simulated time has stood still without being paused, seconds.
        waiting_for
            Participants that simulated time waits for.
        heard_ago_s
            Returns how long ago the last message of a vehicle came, seconds.
        """
        silences = {}
        for name, process in self._crew.vehicle_processes.items():
            silences[name] = heard_ago_s(name)
            if name in self._crew.in_lockstep and name not in self._gone:
                is_late = process in waiting_for
                silences[name] = min(stalled_s, silences[name]) if is_late else 0.0
        return silences

    def look(self, sightings: Mapping[str, Sighting]) -> tuple[dict[str, str], list[str]]:
        """Look at all vehicles; return those that are lost now, with the reason, and remarks."""
        lost: dict[str, str] = {}
        remarks: list[str] = []
        for name, sighting in sightings.items():
            before = self._members[name]
            after = self._members[name] = before.seen(sighting, self._lease)
            if after.presence is before.presence:
                continue
            if after.presence is Presence.LOST and not before.is_replaced:
                lost[name] = after.why
            if after.presence is Presence.PRESENT and name in self._gone:
                self._gone.remove(name)
            remarks += _remark(name, before, after)
        return lost, remarks

    def note(self, vehicles: Iterable[str], why: str, *, is_gone: bool) -> bool:
        """Note that vehicles are lost and let the others hold; return whether there are others.

        `is_gone`: they are no longer heard, and simulated time must not wait for them.
        """
        vehicles = list(vehicles)
        self.lost.update(dict.fromkeys(vehicles, why))
        for name in vehicles:
            self._members[name] = self._members[name].lost(why)
        if is_gone:
            self._gone += [name for name in vehicles if name not in self._gone]
        return self._is_replaced and self.gather()

    def gather(self) -> bool:
        """Let all that can be given a route hold; return whether there are any."""
        if not self.others:
            return False
        self._gather()
        return True

    def regain(self) -> list[str]:
        """Gather for the vehicles that came back, and return them; empty if there are none."""
        back = [n for n, m in self._members.items() if m.presence is Presence.RETURNED]
        if back and not set(back) <= set(self._flying if self.is_gathering else ()):
            self._gather(back)
            return back
        return []

    def withdraw(self, vehicle: str, why: str, by: OrderKind = OrderKind.RETURN) -> None:
        """Let a vehicle return home by an order; it gets no more work."""
        self._members[vehicle] = self._members[vehicle].withdrawn(why)
        self._requests.renew(by, self._crew.vehicle_processes[vehicle], vehicle)

    def moving(self, situation: Situation) -> list[str]:
        """Return the vehicles that are to stand before the rest is planned, and do not yet."""
        return sorted(set(self.others) - situation.still)

    def dismiss_again(self) -> None:
        """Tell a restarted world which vehicles it must not wait for."""
        for name in self._gone:
            self._requests.renew(OrderKind.DISMISS, WORLD, name)

    def advance(self, now_s: float, situation: Situation) -> None:
        """Make the next request: hold, pause time, plan the rest."""
        if self._gathers_since_s is None:
            self._gathers_since_s = now_s
        if not self._requests.all_done(OrderKind.HOLD) and self._flying:
            return
        is_silent = any(m.presence is Presence.SILENT for m in self._members.values())
        if is_silent or self.moving(situation):
            return
        if self._merges(situation) and now_s - self._gathers_since_s < MERGE_S:
            return
        self._requests.add(OrderKind.PAUSE_CLOCK, WORLD)
        if self._requests.all_done(OrderKind.PAUSE_CLOCK):
            self._requests.add(OrderKind.PLAN, PLANNER)

    def go_on(self, routed: Iterable[str] | None = None) -> None:
        """Let vehicles fly the new plan.

        Without a plan those in flight go on with the old one, those that came back return home.
        """
        self.is_gathering = False
        self._requests.forget()
        self.dismiss_again()
        able = self.others
        for name in self._flying if routed is None else routed:
            if name not in able or (routed is None and self._members[name].is_replaced):
                continue
            self._requests.add(OrderKind.FLY, self._crew.vehicle_processes[name], name)
            if routed is None:
                self._requests.add(OrderKind.RESUME, self._crew.vehicle_processes[name], name)
        for name, member in self._members.items():
            if name not in able:
                self._members[name] = member.replaced() if routed is not None else member
            elif routed is not None:
                self._members[name] = member.merged()
            elif member.is_replaced:
                self.withdraw(name, 'nothing is left for it')

    def _merges(self, situation: Situation) -> bool:
        """Return whether a vehicle that came back, or comes home, hands over photographs."""
        return any(
            member.presence in (Presence.RETURNED, Presence.APART)
            for name, member in self._members.items()
            if name in situation.unsettled
        )

    def _gather(self, back: Iterable[str] = ()) -> None:
        flying = {
            request.order.vehicle
            for request in self._requests.of_kind(OrderKind.FLY)
            if request.status is not Status.DONE
        }
        known = flying | set(back) | (set(self._flying) if self.is_gathering else set())
        self._flying = [name for name in self.others if name in known]
        self._gone = [name for name in self._gone if name not in self._flying]
        self.is_gathering = True
        self._gathers_since_s = None
        self._requests.forget()
        self.dismiss_again()
        for name in self._flying:
            self._requests.add(OrderKind.HOLD, self._crew.vehicle_processes[name], name)


def _remark(name: str, before: Member, after: Member) -> list[str]:
    """Return the remark on a change of presence."""
    if after.presence is Presence.SILENT:
        return [f'{name}: silent, it gets no orders']
    if after.presence is Presence.RETURNED:
        return [f'{name}: heard again, holds until what it did is merged']
    if after.presence is Presence.APART and not before.is_replaced:
        return [f'{name}: {after.why}, it gets no orders']
    if after.presence is Presence.PRESENT:
        return [f'{name}: heard again']
    return []
