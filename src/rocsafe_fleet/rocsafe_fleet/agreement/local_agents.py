# SPDX-License-Identifier: Apache-2.0
"""Agents that run in one process: they hear each other at once, and plan once for all."""

from collections import deque
from collections.abc import Iterable

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.fleet_plan import FleetPlan, Wanted

ECHOES = 400
"""Packets that are known by themselves if the link brings them back."""


class LocalAgents:
    """Agents that run in one process.

    Attributes
    ----------
    agents
        By number of their vehicles.
    bytes_sent
        Payload of each agent.
    """

    def __init__(self, agents: Iterable[Agent]) -> None:
        self.agents = {agent.own: agent for agent in agents}
        self.bytes_sent = dict.fromkeys(self.agents, 0)
        self._echoes: deque[bytes] = deque(maxlen=ECHOES)

    def advance(self, now_s: float) -> list[bytes]:
        """Advance all agents; return the packets for agents elsewhere."""
        sent = []
        for agent in self.agents.values():
            for data in agent.advance(now_s):
                self.bytes_sent[agent.own] += len(data)
                self._echoes.append(data)
                sent.append(data)
                self._deliver(data, now_s)
        return sent

    def receive(self, data: bytes, now_s: float) -> None:
        """Take a packet from the link."""
        if data not in self._echoes:
            self._deliver(data, now_s)

    def _deliver(self, data: bytes, now_s: float) -> None:
        for agent in self.agents.values():
            agent.receive(data, now_s)

    @property
    def wanted(self) -> Wanted | None:
        """The newest proposal that an agent here has not planned."""
        found = [wanted for agent in self.agents.values() if (wanted := agent.wanted) is not None]
        return max(found, key=lambda one: one.epoch) if found else None

    @property
    def seeker(self) -> Agent | None:
        """The agent that is to choose the places of a round of the search."""
        return next((agent for agent in self.agents.values() if agent.seeks), None)

    def planned(self, wanted: Wanted, plan: FleetPlan) -> None:
        """Let all agents that know a proposal keep to its plan."""
        for agent in self.agents.values():
            if agent.wanted == wanted:
                agent.planned(wanted, plan)
