# SPDX-License-Identifier: Apache-2.0
"""Agents that compute other plans from the same proposal."""

from collections.abc import Mapping

from rocsafe_fleet.agreement.fleet_plan import FleetPlan
from rocsafe_fleet.agreement.knowledge import Knowledge
from rocsafe_fleet.ledger.records import Epoch


class OtherPlans:
    """Notes who claims another plan than this agent, until it is started again.

    Attributes
    ----------
    alarms
        Epochs in which somebody did.
    """

    def __init__(self) -> None:
        self.alarms: set[Epoch] = set()
        self._starts: dict[int, int] = {}

    def look(
        self,
        members: frozenset[int],
        plan: FleetPlan,
        knowledge: Knowledge,
        beats: Mapping[int, tuple[int, int]],
    ) -> None:
        """Compare what other members of a plan claim."""
        for member in members:
            claim = knowledge.claim(member)
            if claim is None or claim.epoch != plan.epoch or claim.plan_hash == plan.digest:
                continue
            self.alarms.add(plan.epoch)
            self._starts[member] = beats.get(member, (0, 0))[0]

    def agents(self, beats: Mapping[int, tuple[int, int]]) -> frozenset[int]:
        """Return who claimed another plan, and runs still."""
        starts = self._starts.items()
        return frozenset(k for k, start in starts if k in beats and beats[k][0] == start)
