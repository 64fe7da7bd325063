# SPDX-License-Identifier: Apache-2.0
"""Published ways to share work over a lossy radio, in rounds: CBBA, PI, auction by insertion.

In each round every agent sends one message to all others; each link loses it or not by itself
(the scheme of Nayak et al. 2020, "Experimental comparison of decentralized task allocation
algorithms under imperfect communication", doi 10.1109/LRA.2019.2963646). An agent that has news
sends; who has none for a round stays silent, but answers to contradictions. Messages are counted
until nobody has news, at most `MOST_ROUNDS`.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import cast

import numpy as np
from numpy.typing import NDArray

MOST_ROUNDS = 200
# Rounds without news after which an agent is quiet; lost messages are sent again so often.
PATIENCE = 10
Loses = Callable[[int, int], bool]
Link = Callable[[float, np.random.Generator], Loses]
Paths = list[list[int]]
Told = tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]


@dataclass(frozen=True)
class Work:
    """Agents in the air, points to visit, and homes, metres east and north."""

    starts: NDArray[np.float64]
    points: NDArray[np.float64]
    homes: NDArray[np.float64]

    @property
    def count(self) -> int:
        """Number of agents."""
        return len(self.starts)

    def length_m(self, agent: int, path: Sequence[int]) -> float:
        """Return the way of an agent over points to its home."""
        stops = [self.starts[agent], *(self.points[k] for k in path), self.homes[agent]]
        return float(sum(math.dist(a, b) for a, b in pairwise(stops)))

    def insertion(self, agent: int, path: Sequence[int], point: int) -> tuple[float, int]:
        """Return by how much a point lengthens a path at its best place, and that place."""
        stops = np.vstack([self.starts[agent], self.points[list(path)], self.homes[agent]])
        here = self.points[point]
        to = np.hypot(*(stops - here).T)
        legs = np.hypot(*np.diff(stops, axis=0).T)
        extra = to[:-1] + to[1:] - legs
        best = int(np.argmin(extra))
        return float(extra[best]), best


@dataclass(frozen=True)
class Result:
    """What came of an agreement.

    Attributes
    ----------
    longest_m
        Longest way of an agent.
    unassigned, twice
        Points that nobody has, and that more than one has.
    """

    longest_m: float
    messages: int
    unassigned: int
    twice: int


def burst_chain(mean: float, random: np.random.Generator) -> Loses:
    """Return a Gilbert-Elliott link with a mean loss: bad links lose everything."""
    to_good = min(0.3, (1.0 - mean) / max(mean, 1e-9))
    to_bad = to_good * mean / (1.0 - mean)
    bad: dict[tuple[int, int], bool] = {}

    def loses(sender: int, receiver: int) -> bool:
        link = sender, receiver
        is_bad = bad.get(link, bool(random.random() < mean))
        bad[link] = is_bad != bool(random.random() < (to_good if is_bad else to_bad))
        return is_bad

    return loses


def independent(mean: float, random: np.random.Generator) -> Loses:
    """Return links that lose each message by itself (Bernoulli)."""
    return lambda _sender, _receiver: bool(random.random() < mean)


@dataclass
class Bidder:
    """An agent of CBBA: bundle, path, and what it knows of winners, bids and times."""

    own: int
    count: int
    points: int
    bundle: list[int] = field(default_factory=list)
    path: list[int] = field(default_factory=list)
    rivals: dict[int, float] = field(default_factory=dict)
    bids: NDArray[np.float64] = field(init=False)
    winners: NDArray[np.int64] = field(init=False)
    heard: NDArray[np.int64] = field(init=False)

    def __post_init__(self) -> None:
        self.bids = np.zeros(self.points)
        self.winners = np.full(self.points, -1)
        self.heard = np.full(self.count, -1)

    def told(self) -> Told:
        """Return what it sends."""
        return self.bids.copy(), self.winners.copy(), self.heard.copy()


def cbba(work: Work, loses: Loses) -> Result:
    """Share points by the consensus-based bundle algorithm (Choi, Brunet, How 2009).

    Scores are discounted times of arrival, 0.999 a metre, with the usual warp that makes the gains
    of a bundle fall; a bundle has at most its share of the points and a quarter.
    """
    size = math.ceil(1.25 * len(work.points) / work.count)
    agents = [Bidder(k, work.count, len(work.points)) for k in range(work.count)]

    def think(agent: Bidder) -> None:
        _build(work, agent, size)

    def hear(agent: Bidder, sender: int, message: object, now: int) -> None:
        _agree(agent, sender, cast(Told, message), now)
        _release(agent)

    return _rounds(work, agents, think, hear, loses)


def _gain(work: Work, agent: Bidder, point: int) -> tuple[float, int]:
    extra, place = work.insertion(agent.own, agent.path, point)
    arrival = work.length_m(agent.own, agent.path[:place]) + extra
    gain = 0.999**arrival
    # Warped: no later point of a bundle counts more than an earlier one (Johnson et al. 2012).
    least = min((agent.bids[k] for k in agent.bundle), default=math.inf)
    return min(gain, float(least)), place


def _build(work: Work, agent: Bidder, size: int) -> None:
    while len(agent.bundle) < size:
        best = (0.0, -1, 0)
        for point in range(agent.points):
            if point in agent.bundle:
                continue
            gain, place = _gain(work, agent, point)
            known = agent.bids[point], -agent.winners[point]
            if (gain, -agent.own) > known and gain > best[0]:
                best = gain, point, place
        gain, point, place = best
        if point < 0:
            return
        agent.bundle.append(point)
        agent.path.insert(place, point)
        agent.bids[point], agent.winners[point] = gain, agent.own


def _agree(  # noqa: C901 - a table of rules, as published
    agent: Bidder,
    sender: int,
    message: Told,
    now: int,
) -> None:
    """Apply the decision rules of CBBA, table 1, to each point."""
    bids, winners, heard = message
    own = agent.own
    for k in range(agent.points):
        theirs, mine = int(winners[k]), int(agent.winners[k])
        better = (bids[k], -theirs) > (agent.bids[k], -mine)
        fresher = theirs >= 0 and heard[theirs] > agent.heard[theirs]
        if theirs == sender:
            takes = mine == sender or mine == -1 or better
            if mine not in (own, sender, -1):
                takes = better or heard[mine] > agent.heard[mine]
        elif theirs == own:
            takes, is_reset = False, mine == sender
            is_reset |= mine not in (own, sender, -1) and heard[mine] > agent.heard[mine]
            if is_reset:
                agent.bids[k], agent.winners[k] = 0.0, -1
        elif theirs == -1:
            takes = mine == sender or (mine not in (own, -1) and heard[mine] > agent.heard[mine])
        elif mine == own:
            takes = fresher and better
        elif mine == sender:
            takes = fresher
            if not takes:
                agent.bids[k], agent.winners[k] = 0.0, -1
        elif mine in (-1, theirs):
            takes = fresher
        else:
            takes = fresher and (better or heard[mine] > agent.heard[mine])
            if not takes and heard[mine] > agent.heard[mine] and not fresher:
                agent.bids[k], agent.winners[k] = 0.0, -1
        if takes:
            agent.bids[k], agent.winners[k] = bids[k], theirs
    agent.heard = np.maximum(agent.heard, heard)
    agent.heard[sender] = now


def _release(agent: Bidder) -> None:
    """Give up the points that others have, and all that were added after the first of them."""
    lost = [n for n, point in enumerate(agent.bundle) if agent.winners[point] != agent.own]
    if not lost:
        return
    for point in agent.bundle[lost[0] :]:
        agent.path.remove(point)
        if agent.winners[point] == agent.own:
            agent.bids[point], agent.winners[point] = 0.0, -1
    agent.bundle = agent.bundle[: lost[0]]


def pi(work: Work, loses: Loses) -> Result:
    """Share points by performance impact (Zhao, Meng, Chung 2016).

    The significance of a point is by how much it lengthens the way of its agent. An agent takes
    over the point whose significance it lowers most, and gives up those that cost it more than
    others. A path has at most its share of the points and a quarter.
    """
    size = math.ceil(1.25 * len(work.points) / work.count)
    agents = [Bidder(k, work.count, len(work.points)) for k in range(work.count)]
    for agent in agents:
        agent.bids[:] = -1e9

    def think(agent: Bidder) -> None:
        _include(work, agent, size)

    def hear(agent: Bidder, sender: int, message: object, now: int) -> None:
        _agree(agent, sender, cast(Told, message), now)
        agent.bids[agent.winners == -1] = -1e9
        _remove(work, agent)

    return _rounds(work, agents, think, hear, loses)


def _include(work: Work, agent: Bidder, size: int) -> None:
    while len(agent.path) < size:
        best = (1e-6, -1, 0, 0.0)
        for point in range(agent.points):
            if point in agent.path:
                continue
            extra, place = work.insertion(agent.own, agent.path, point)
            gain = -extra - agent.bids[point]
            if gain > best[0]:
                best = gain, point, place, extra
        _, point, place, extra = best
        if point < 0:
            return
        agent.path.insert(place, point)
        agent.bids[point], agent.winners[point] = -extra, agent.own
    _refresh(work, agent)


def _refresh(work: Work, agent: Bidder) -> None:
    """Bring the significance of the own points up to date."""
    whole = work.length_m(agent.own, agent.path)
    for point in agent.path:
        rest = [other for other in agent.path if other != point]
        agent.bids[point] = work.length_m(agent.own, rest) - whole


def _remove(work: Work, agent: Bidder) -> None:
    agent.path = [point for point in agent.path if agent.winners[point] == agent.own]
    _refresh(work, agent)


def auction(work: Work, loses: Loses) -> Result:
    """Share points by a sequential auction: each goes to whose way is shortest with it.

    In each round an agent bids for the point that lengthens its way least, with that way as its
    price; who thinks that its bid is the lowest has the point.
    """
    agents = [Bidder(k, work.count, len(work.points)) for k in range(work.count)]

    def think(agent: Bidder) -> None:
        agent.bundle = []
        open_points = np.flatnonzero(agent.winners == -1)
        if not len(open_points):
            return
        whole = work.length_m(agent.own, agent.path)
        prices = [work.insertion(agent.own, agent.path, int(k))[0] for k in open_points]
        best = int(np.argmin(prices))
        agent.bundle = [int(open_points[best])]
        agent.bids[agent.bundle[0]] = -(whole + prices[best])

    def hear(agent: Bidder, sender: int, message: object, now: int) -> None:
        bids, winners, _ = cast(Told, message)
        taken = (winners == sender) & (agent.winners == -1)
        agent.winners[taken] = sender
        # Of two that have a point the one with the lower number keeps it.
        lost = (winners == sender) & (agent.winners == agent.own) & (sender < agent.own)
        agent.winners[lost] = sender
        agent.path = [point for point in agent.path if agent.winners[point] == agent.own]
        agent.heard[sender] = now
        agent.rivals[sender] = float(bids.max())

    def close(agent: Bidder) -> None:
        if agent.bundle:
            point = agent.bundle[0]
            price = agent.bids[point]
            if all((price, -agent.own) > (bid, -k) for k, bid in agent.rivals.items()):
                place = work.insertion(agent.own, agent.path, point)[1]
                agent.path.insert(place, point)
                agent.winners[point] = agent.own
        agent.bids[:] = -math.inf
        agent.rivals.clear()

    for agent in agents:
        agent.bids[:] = -math.inf
    return _rounds(work, agents, think, hear, loses, close)


def _rounds(
    work: Work,
    agents: list[Bidder],
    think: Callable[[Bidder], None],
    hear: Callable[[Bidder, int, object, int], None],
    loses: Loses,
    close: Callable[[Bidder], None] = lambda _agent: None,
) -> Result:
    """Let the agents think and send until nobody has news."""
    messages, quiet = 0, [0] * len(agents)
    known = [agent.winners.copy() for agent in agents]
    for now in range(MOST_ROUNDS):
        for agent in agents:
            think(agent)
            agent.heard[agent.own] = now
        sent = [(agent.own, agent.told()) for agent in agents if quiet[agent.own] < PATIENCE]
        messages += len(sent)
        for sender, message in sent:
            for agent in agents:
                if agent.own != sender and not loses(sender, agent.own):
                    hear(agent, sender, message, now)
        for agent in agents:
            close(agent)
            has_news = bool((agent.winners != known[agent.own]).any())
            known[agent.own] = agent.winners.copy()
            quiet[agent.own] = 0 if has_news else quiet[agent.own] + 1
        if min(quiet) >= PATIENCE:
            break
    return judged(work, [agent.path for agent in agents], messages)


def judged(work: Work, paths: Paths, messages: int) -> Result:
    """Return what paths are worth."""
    counts = np.bincount([p for path in paths for p in path], minlength=len(work.points))
    return Result(
        longest_m=max(work.length_m(k, path) for k, path in enumerate(paths)),
        messages=messages,
        unassigned=int((counts == 0).sum()),
        twice=int((counts > 1).sum()),
    )


METHODS: dict[str, Callable[[Work, Loses], Result]] = {'CBBA': cbba, 'PI': pi, 'auction': auction}
LINKS: dict[str, Link] = {
    'Bernoulli': independent, 'Gilbert-Elliott': burst_chain,
}  # fmt: skip
