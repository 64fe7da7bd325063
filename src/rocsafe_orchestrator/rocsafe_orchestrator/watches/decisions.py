# SPDX-License-Identifier: Apache-2.0
"""Decisions of the orchestrator, each once, for the timeline of the report."""

from dataclasses import dataclass

from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.request import Order

INFO, WARN, ERROR = 0, 1, 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """A decision of the orchestrator; the fields mean what those of ``Decision.msg`` do."""

    kind: str
    text: str
    severity: int = INFO
    vehicles: tuple[str, ...] = ()
    reason: str = ''


class Decisions:
    """Finds what is new in a mission since the last call."""

    def __init__(self) -> None:
        self._phase: Phase | None = None
        self._fault_count = 0
        self._lost: frozenset[str] = frozenset()
        self._sent: set[Order] = set()

    def of_mission(self, mission: Mission) -> list[Decision]:
        """Return new losses, faults, and the phase if it is another."""
        found = [
            Decision(kind='loss', text='lost', severity=WARN, vehicles=(name,), reason=why)
            for name, why in mission.fleet.lost.items()
            if name not in self._lost
        ]
        self._lost = frozenset(mission.fleet.lost)
        found += [
            Decision(kind='fault', text=text, severity=ERROR)
            for text in mission.faults[self._fault_count :]
        ]
        self._fault_count = len(mission.faults)
        if mission.phase is not self._phase:
            self._phase = mission.phase
            self._sent.clear()
            found.append(Decision(kind='phase', text=mission.phase.name.lower()))
        return found

    def of_order(self, order: Order) -> list[Decision]:
        """Return an order that was not sent in this phase before: repetitions are left out."""
        if order in self._sent:
            return []
        self._sent.add(order)
        vehicles = (order.vehicle,) if order.vehicle else ()
        return [Decision(kind='order', text=order.kind.value, vehicles=vehicles)]
