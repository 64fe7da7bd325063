# SPDX-License-Identifier: Apache-2.0
"""The agent of one vehicle: knows the others, agrees with those that it hears, keeps a route.

The live agent with the lowest number coordinates. It proposes a situation, and each agent computes
the same plan from it. No rounds of votes are needed: the highest epoch (number, coordinator) that
an agent knows holds. Parts of the fleet that do not hear each other go on by themselves, and agree
again as soon as they meet.
"""

from collections.abc import Iterable
from dataclasses import replace

from rocsafe_fleet.agreement.exchange import Exchange
from rocsafe_fleet.agreement.fleet_plan import FleetPlan, Wanted
from rocsafe_fleet.agreement.knowledge import Knowledge
from rocsafe_fleet.agreement.options import MOST_AGENTS, MOST_POINTS, AgreementOptions
from rocsafe_fleet.agreement.other_plans import OtherPlans
from rocsafe_fleet.agreement.possible_routes import PossibleRoutes
from rocsafe_fleet.agreement.rounds import Rounds
from rocsafe_fleet.errors import PacketError
from rocsafe_fleet.ledger.ledger import Kind, Ledger
from rocsafe_fleet.ledger.packet import MOST_BYTES, Packet, decode, encode
from rocsafe_fleet.ledger.records import (
    FIRST_EPOCH,
    Claim,
    Epoch,
    Place,
    Proposal,
    proposal_of,
    set_bytes,
    set_of,
)
from rocsafe_fleet.membership.identity import Identity
from rocsafe_fleet.membership.membership import NEVER, Membership
from rocsafe_fleet.search.search_round import SearchRound

Numbers = frozenset[int]


class Agent:
    """The agent of one vehicle. It reads no clock: `now_s` is an argument, seconds.

    Parameters
    ----------
    own
        Number of its vehicle in the survey's plan.
    first
        Plan with which the survey begins.
    key
        Key of the fleet, up to 64 bytes.
    incarnation
        Number of this start of the agent, higher than those before.
    rounds
        Most rounds of the search that follow the survey.

    Attributes
    ----------
    ledger
        What it knows.
    knowledge
        What the ledger says.
    plan
        What it keeps to.
    proposal
        From which the plan was made.
    refused
        Packets that were damaged, or of another fleet.
    """

    def __init__(
        self,
        own: int,
        first: FleetPlan,
        key: bytes,
        now_s: float,
        incarnation: int = 1,
        options: AgreementOptions | None = None,
        rounds: int = 0,
    ) -> None:
        self._options = options or AgreementOptions()
        self._count = max(first.routes, default=0) + 1
        points = [p for route in first.routes.values() for p in route]
        self._survey = frozenset(points) | first.left_out
        _check(own, self._count, self._survey)
        self.own = own
        self.ledger = Ledger((own, incarnation))
        self.knowledge = Knowledge(self.ledger, self._count, max(self._survey, default=0) + 1)
        self.plan = first
        self.proposal = Proposal(number=0, members=())
        self.refused = 0
        self._others = OtherPlans()
        self._rounds = Rounds(self.knowledge, rounds, self._options.patience_s)
        self._key = key
        self._membership = Membership(
            own, self._count, incarnation, now_s, self._options.membership
        )
        self._identity = Identity(incarnation, self._options.membership.longest_s)
        self._exchange = Exchange(self.ledger, self._count)
        self._places: dict[int, tuple[tuple[int, int], Place]] = {}
        self._route = first.routes.get(own, ())
        self._routes = PossibleRoutes(first.routes, self.knowledge)
        self._live = self._everyone
        self._next_beat_s = now_s
        self._sent_s = now_s - self._options.least_gap_s
        self._reason_s: float | None = None
        self._repeats = (0, now_s)
        self._proposed = 1
        self._looked_at: object = None
        self.ledger.write(Kind.ABLE, b'')

    # What the agent knows.

    @property
    def _everyone(self) -> Numbers:
        return frozenset(range(self._count))

    @property
    def live(self) -> Numbers:
        """Agents that are heard, as of the last `advance`."""
        return self._live

    @property
    def aloft(self) -> Numbers:
        """Vehicles in the air whose agents are heard."""
        places = self._places.items()
        return frozenset(k for k, (_, place) in places if place.is_aloft and k in self._live)

    @property
    def _landing(self) -> Numbers:
        """Vehicles that take no route until they stand."""
        return frozenset(k for k, (_, place) in self._places.items() if place.is_landing)

    @property
    def visited(self) -> Numbers:
        """Viewpoints that anybody has photographed."""
        return self.knowledge.visited

    @property
    def _points(self) -> Numbers:
        extra = self.knowledge.extra_points
        return self._survey | extra if extra else self._survey

    @property
    def left(self) -> Numbers:
        """Viewpoints that nobody has photographed, and somebody can reach."""
        return self._points - self.visited - self.plan.left_out

    @property
    def route(self) -> tuple[int, ...]:
        """Viewpoints that its vehicle is to visit, in order."""
        return tuple(point for point in self._route if point not in self.visited)

    @property
    def epoch(self) -> Epoch:
        """The epoch whose plan it keeps to."""
        return self.plan.epoch

    @property
    def wanted(self) -> Wanted | None:
        """The newest proposal if it is not planned yet and its zones are known.

        A proposal whose coordinator did not hear this agent is ignored.
        """
        mine = [one for one in self.knowledge.proposals if self.own not in one[1].silent]
        epoch, proposal = max(mine, key=lambda one: one[0], default=(FIRST_EPOCH, self.proposal))
        if epoch <= self.plan.epoch:
            return None
        rings, extra = self.knowledge.rings(proposal), self.knowledge.places(proposal.rounds)
        if rings is None or extra is None:
            return None
        return Wanted(proposal=proposal, coordinator=epoch[1:], rings=rings, extra=extra)

    @property
    def alarms(self) -> set[Epoch]:
        """Epochs in which somebody claims another plan from the same proposal."""
        return self._others.alarms

    @property
    def seeks(self) -> int:
        """Number of the round of the search whose places it is to choose now; 0: none."""
        return self._rounds.sought

    @property
    def is_done(self) -> bool:
        """Whether nothing is left that somebody could fly, and no round follows."""
        if self.wanted is not None or self.plan.error:
            return self.wanted is None
        return not self.left and (self._rounds.are_over or not self._parts()[0])

    # What its vehicle does.

    def move(self, place: Place) -> None:
        """Note where its vehicle is."""
        self._places[self.own] = self._membership.beats[self.own], place

    def visit(self, points: Iterable[int]) -> None:
        """Note that its vehicle has photographed these viewpoints."""
        mine = self.ledger.newest(self.own, Kind.VISITED)
        known = set_of(mine) if mine else frozenset()
        self.ledger.write(Kind.VISITED, set_bytes(known | set(points)))

    def disable(self, why: str) -> None:
        """Note that its vehicle takes no more work; empty: it does again."""
        self.ledger.write(Kind.ABLE, why.encode())

    def planned(self, wanted: Wanted, plan: FleetPlan) -> None:
        """Keep to the plan of a proposal. Who is no member of it keeps its route."""
        if wanted.epoch <= self.plan.epoch:
            return
        self.plan, self.proposal = plan, wanted.proposal
        if not plan.error:
            self._routes.note(plan.epoch, plan.routes)
        if self.own in wanted.proposal.names:
            self._route = plan.routes[self.own]
        claim = Claim(epoch=plan.epoch, plan_hash=plan.digest)
        self.ledger.write(Kind.CLAIM, claim.encoded())

    def decide(self, chosen: SearchRound) -> None:
        """Tell all which places are those of the round that it seeks."""
        if chosen.number == self.seeks:
            self.ledger.write(Kind.ROUND, chosen.encoded(), chosen.number)
            self._rounds.stop()

    # Packets.

    def receive(self, data: bytes, now_s: float) -> None:
        """Take a packet."""
        try:
            packet = decode(data, self._key)
        except PacketError:
            self.refused += 1
            return
        if packet.sender >= self._count:
            return
        self._identity.hear(
            packet.beats.get(self.own, NEVER),
            self._membership.beats[self.own],
            now_s,
            is_answer=packet.sender != self.own,
        )
        if packet.sender == self.own:
            return
        self._membership.hear(packet.beats, now_s)
        beat = packet.beats.get(packet.sender, (0, 0))
        known = self._places.get(packet.sender)
        if packet.place is not None and (known is None or known[0] <= beat):
            self._places[packet.sender] = beat, packet.place
        if packet.sender not in self._live:  # they meet again
            self._exchange.asks = True
            self._next_beat_s = now_s
        rank = sorted(self._live | {self.own}).index(self.own)
        self._exchange.take(packet, rank, now_s)

    def advance(self, now_s: float) -> list[bytes]:
        """Look who is heard, coordinate if it is this agent's turn, return packets to send."""
        if self._identity.rests(now_s):
            self._rounds.sought = 0
            return []
        if self._identity.incarnation != self.ledger.writer[1]:
            self._begin_again()
        live = self._membership.live(now_s)
        if live != self._live:
            self._live = live
            self._next_beat_s = now_s
        self._coordinate(now_s)
        self._rounds.look(now_s, is_time=self._may_choose)
        is_beat = now_s >= self._next_beat_s
        is_urgent = is_beat or self._exchange.has_news or self._exchange.is_due(now_s)
        if not is_urgent or now_s - self._sent_s < self._options.least_gap_s - 1e-9:
            return []
        if is_beat:
            self._next_beat_s = now_s + self._period_s
        return [self._packet(now_s)]

    def _begin_again(self) -> None:
        """Write as another start of the agent from now on."""
        known = {kind: self.ledger.newest(self.own, kind) for kind in (Kind.ABLE, Kind.VISITED)}
        self.ledger.writer = self.own, self._identity.incarnation
        self._membership.begin_again(self._identity.incarnation)
        self._exchange.repeat(1)
        self._repeats = 0, 0.0
        for kind, value in known.items():
            if value is not None:
                self.ledger.write(kind, value)

    @property
    def _period_s(self) -> float:
        """Time between heartbeats: shorter while somebody is missing, who may come back."""
        is_complete = self._live | self.knowledge.unable.keys() == self._everyone
        return self._options.membership.period_s * (1.0 if is_complete else 0.5)

    def _packet(self, now_s: float) -> bytes:
        self._sent_s = now_s
        self._membership.beat()
        place = self._places.get(self.own)
        packet = Packet(
            sender=self.own,
            beats=self._membership.beats,
            digest=self.ledger.digest,
            place=None if place is None else place[1],
            vector=self._exchange.vector(),
            deltas=self._exchange.deltas(now_s),
        )
        data = encode(packet, self._key)
        if len(data) > MOST_BYTES:
            # Data that others need is more important than what this agent asks for.
            self._exchange.asks = True
            data = encode(replace(packet, vector={}), self._key)
        return data

    # Agreement.

    def _coordinate(self, now_s: float) -> None:
        """Propose a situation if there is a reason, or repeat the last proposal."""
        places = len(self._places), self._landing
        state = (self.ledger.digest, self._live, self.plan.epoch, places)
        if state == self._looked_at and self._reason_s is None:
            self._repeat(now_s)
            return
        self._looked_at = state
        others = self.proposal.names - {self.own}
        self._others.look(others, self.plan, self.knowledge, self._membership.beats)
        if min(self._live) != self.own or self.wanted is not None:
            self._reason_s = None
            return
        members, silent = self._parts()
        if not self._has_reason(members, silent):
            self._reason_s = None
            self._repeat(now_s)
        elif self._reason_s is None:
            self._reason_s = now_s
        elif now_s - self._reason_s >= self._waits_s(members, now_s):
            self._reason_s = None
            self._propose((members - self._landing) & self._places.keys(), silent)
            self._repeats = self._options.repeats, now_s

    @property
    def _may_choose(self) -> bool:
        """Whether it coordinates, nothing is left, and a vehicle can fly another round."""
        is_next = not self._rounds.are_over and not self.left and self.wanted is None
        is_own = is_next and min(self._live) == self.own and not self.plan.error
        return is_own and bool(self._parts()[0] & self._places.keys())

    def _waits_s(self, members: Numbers, now_s: float) -> float:
        """Return how long to wait before a proposal, seconds.

        It waits longer while places are old, and while another member may have fallen silent:
        agents that are cut off together are missed one by one.
        """
        if members & self._membership.late(now_s):
            return self._options.patience_s
        beats, fresh = self._membership.beats, self._options.fresh_beats
        for member in members:
            known = self._places.get(member)
            beat = beats.get(member, (0, 0))
            if known is None or known[0][0] != beat[0] or beat[1] - known[0][1] > fresh:
                return self._options.patience_s
        return self._options.settle_s

    def _parts(self) -> tuple[Numbers, Numbers]:
        """Return who takes part in the next plan, and who may fly on unheard."""
        unable = frozenset(self.knowledge.unable)
        odd = self._others.agents(self._membership.beats)
        members = self._live - unable - odd
        silent = (self._everyone - self._live - unable) | (odd & self._live)
        return members, silent

    def _has_reason(self, members: Numbers, silent: Numbers) -> bool:
        free = members - self._landing
        if not free & self._places.keys() or not self._points - self.visited:
            return False
        if self.plan.epoch == FIRST_EPOCH:
            before, unheard = self._everyone, frozenset[int]()
        else:
            before, unheard = self.proposal.names, self.proposal.silent
        if any(epoch > self.plan.epoch for epoch, _ in self.knowledge.proposals):
            return True  # others keep to a plan that was made without this agent
        is_other = bool(before - members or free - before)
        if is_other or silent != unheard or self.knowledge.zones != self.proposal.exclusions:
            return bool(self.left) or is_other
        open_points = [p for k in members for p in self.plan.routes.get(k, ())]
        return bool(self.left) and self.visited.issuperset(open_points) and not self.plan.error

    def _propose(self, members: Numbers, silent: Numbers) -> None:
        epochs = [self.plan.epoch, *(epoch for epoch, _ in self.knowledge.proposals)]
        theirs = {p for k in silent for p in self._routes.points(k)}
        if silent >= self.proposal.silent:
            # Points of vehicles that are heard again are no longer flown last.
            theirs |= self.proposal.last
        proposal = Proposal(
            number=max(epochs)[0] + 1,
            members=tuple((k, self._places[k][1]) for k in sorted(members)),
            silent=silent,
            visited=self.visited,
            last=frozenset(theirs) - self.visited,
            exclusions=self.knowledge.zones,
            rounds=self.knowledge.open_rounds(),
        )
        self.ledger.write(Kind.PROPOSAL, proposal.encoded())
        self._proposed = self.ledger.vector[self.ledger.writer]

    def _repeat(self, now_s: float) -> None:
        """Send the last own proposal again while members have not claimed a plan of it."""
        left, due_s = self._repeats
        own = self.ledger.newest(self.own, Kind.PROPOSAL)
        if own is None or not left or now_s < due_s + self._options.repeat_s:
            return
        proposal = proposal_of(own)
        epoch = proposal.number, *self.ledger.writer
        claims = [self.knowledge.claim(member) for member in proposal.names & self._live]
        waits = any(claim is None or claim.epoch < epoch for claim in claims)
        self._repeats = (left - 1 if waits else 0), now_s
        if waits:
            self._exchange.repeat(self._proposed)


def _check(own: int, count: int, points: Numbers) -> None:
    if not 0 <= own < count <= MOST_AGENTS:
        raise ValueError(f'agent {own} of {count}: must be at most {MOST_AGENTS} of them')
    most = max(points, default=0)
    if most >= MOST_POINTS:
        raise ValueError(f'viewpoint {most}: must be below {MOST_POINTS} with agents')
