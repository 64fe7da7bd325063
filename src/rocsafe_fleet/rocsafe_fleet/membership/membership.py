# SPDX-License-Identifier: Apache-2.0
"""Vehicles that are heard: heartbeats, passed on by the vehicles that heard them.

Each agent counts its heartbeats and tells the newest of every agent that it knows of (van Renesse,
Minsky, Hayden 1998, "A gossip-style failure detection service"). A vehicle that one member still
hears is live for all members. No clocks are compared: what counts is when a newer heartbeat became
known here.
"""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

from rocsafe_fleet.ledger.packet import Beat
from rocsafe_geo.limits import require_count, require_positive

NEVER: Beat = (0, 0)
OVERDUE = 1.5
"""A heartbeat is overdue after so many periods."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MembershipOptions:
    """Limits of the detection of losses.

    Attributes
    ----------
    period_s
        Between two heartbeats, seconds.
    missed
        Heartbeats that may be missing before a vehicle counts as silent.
    longest_s
        A vehicle that is not heard for longer is silent, however bad the link was before, seconds.
    gaps
        Number of past gaps between heartbeats whose 99th percentile is allowed for.
    """

    period_s: float = 1.0
    missed: int = 3
    longest_s: float = 12.0
    gaps: int = 50

    def __post_init__(self) -> None:
        require_positive('period_s', self.period_s, 's')
        require_count('missed', self.missed, 1, 100)
        require_positive('longest_s', self.longest_s, 's')
        require_count('gaps', self.gaps, 1, 1000)


class _Member:
    """What is known of one agent."""

    def __init__(self, now_s: float, gaps: int) -> None:
        self.beat: Beat = NEVER
        self.heard_s = now_s
        self.gaps: deque[float] = deque(maxlen=gaps)


class Membership:
    """Keeps which agents are live, as one of them knows it.

    Parameters
    ----------
    own
        Number of this agent.
    count
        Number of agents, whose numbers are from 0; all of them count as heard in the beginning.
    incarnation
        Number of this start of the agent.
    now_s
        Time in seconds, as in all methods.
    """

    def __init__(
        self, own: int, count: int, incarnation: int, now_s: float, options: MembershipOptions
    ) -> None:
        self._own = own
        self._options = options
        self._members = {member: _Member(now_s, options.gaps) for member in range(count)}
        self._members[own].beat = (incarnation, 0)

    @property
    def beats(self) -> dict[int, Beat]:
        """Newest heartbeat of each agent that was ever heard."""
        return {n: member.beat for n, member in self._members.items() if member.beat > NEVER}

    def begin_again(self, incarnation: int) -> None:
        """Count own heartbeats from 0, as another start of the agent."""
        self._members[self._own].beat = (incarnation, 0)

    def beat(self) -> None:
        """Count an own heartbeat."""
        own = self._members[self._own]
        own.beat = own.beat[0], own.beat[1] + 1

    def hear(self, beats: Mapping[int, Beat], now_s: float) -> None:
        """Take heartbeats that somebody knows of."""
        for number, beat in beats.items():
            member = self._members.get(number)
            if member is None or number == self._own or beat <= member.beat:
                continue
            if member.beat > NEVER and now_s - member.heard_s <= self._options.longest_s:
                member.gaps.append(now_s - member.heard_s)
            member.beat, member.heard_s = beat, now_s

    def limit_s(self, number: int) -> float:
        """Return how long an agent may be unheard before it counts as silent."""
        least_s = self._options.period_s * self._options.missed
        gaps = sorted(self._members[number].gaps)
        usual_s = gaps[math.ceil(0.99 * len(gaps)) - 1] if gaps else 0.0
        return min(max(least_s, usual_s), max(least_s, self._options.longest_s))

    def late(self, now_s: float) -> frozenset[int]:
        """Return the agents of which a heartbeat is overdue."""
        longest_s = OVERDUE * self._options.period_s
        members = self._members.items()
        return frozenset(n for n, m in members if n != self._own and now_s - m.heard_s > longest_s)

    def live(self, now_s: float) -> frozenset[int]:
        """Return the agents that are heard, this one included."""
        return frozenset(
            number
            for number, member in self._members.items()
            if number == self._own or now_s - member.heard_s <= self.limit_s(number)
        )
