# SPDX-License-Identifier: Apache-2.0
"""Hostile schedules for agents: `python benchmarks/fleet_hostile.py [--first N] [--count N]`.

Each seed draws a radio, clocks that are wrong and drift, and some of: cuts that change and heal in any order, ways
that carry in one direction only, vehicles that are lost, agents that die and start again with
nothing, with an old ledger or with the number of an earlier start, a second agent of the same
vehicle, packets that are damaged or come again much later. Plans are dealt by a rule that costs no
time, so that thousands of schedules are flown. What must hold in each: no viewpoint is missing,
all agents that hear each other end with one plan and one ledger, vehicles stay apart, no packet is longer than a
frame, and the trial ends.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from fleet import survey

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.fleet_plan import FleetPlan, Ring, SharedPlans
from rocsafe_fleet.ledger.ledger import Writer
from rocsafe_fleet.ledger.packet import MOST_BYTES
from rocsafe_fleet.ledger.records import Proposal
from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.trial import KEY, Trial, TrialOptions
from rocsafe_geo.position import level_offset_m
from rocsafe_planner.plan.plan import SurveyPlan

LAST_EVENT_S = 50.0
SETTLE_S = 45.0


def dealt(plan: SurveyPlan) -> Callable[[Proposal, Writer, tuple[Ring, ...]], FleetPlan]:
    """Return a rule that deals the viewpoints of a proposal: each to the nearest of the idlest."""
    views = {view.id: view.position for route in plan.routes for view in route.viewpoints}
    origin = plan.request.regions[0].area.centroid()
    places = {number: level_offset_m(origin, where) for number, where in views.items()}

    def plan_of(proposal: Proposal, coordinator: Writer, _: tuple[Ring, ...]) -> FleetPlan:
        at = {k: level_offset_m(origin, one.position) for k, one in proposal.members}
        routes: dict[int, list[int]] = {k: [] for k in at}
        for group in (views.keys() - proposal.visited - proposal.last, proposal.last):
            rest = set(group)
            while rest:
                idle = min(routes, key=lambda k: (len(routes[k]), k))
                here = at[idle]
                best = min(rest, key=lambda p: (math.dist(here, places[p]), p))
                rest.discard(best)
                routes[idle].append(best)
                at[idle] = places[best]
        found = {k: tuple(route) for k, route in routes.items()}
        return FleetPlan(epoch=(proposal.number, *coordinator), routes=found)

    return plan_of


class Hostile(Trial):
    """A trial whose agents have clocks of their own, and a radio that damages and replays."""

    def __init__(self, plan: SurveyPlan, seed: int, plans: SharedPlans) -> None:
        self.random = random = np.random.default_rng(seed)
        burst = (0.05, 0.3) if random.random() < 0.3 else (0.0, 1.0)
        radio = RadioOptions(
            loss=float(random.choice([0.0, 0.2, 0.4])), burst=burst,
            duplicates=float(random.choice([0.0, 0.1])),
            jitter_s=float(random.choice([0.03, 0.3, 1.5])),
        )  # fmt: skip
        options = TrialOptions(radio=radio, step_s=0.25, longest_s=1500.0)
        super().__init__(plan, options, random, plans)
        count = len(self.agents)
        self.offset_s = random.uniform(-1e5, 1e5, count)
        self.rate = 1.0 + random.uniform(-0.02, 0.02, count)
        self.starts = [1] * count
        self.twins: list[Agent] = []
        self.heard: list[bytes] = []
        self.deaf: set[tuple[int, int]] = set()
        self.kept: dict[int, Agent] = {}
        self.log: list[str] = []
        self.damage = float(random.choice([0.0, 0.05]))
        self.longest = 0
        self.failed: set[int] = set()
        for k in range(count):
            self._start(k, self.start(1))

    def clock_s(self, number: int) -> float:
        """Return what the clock of an agent shows."""
        return float(self.offset_s[number] + self.rate[number] * self.now_s)

    def _start(self, number: int, incarnation: int) -> Agent:
        agent = Agent(
            number, self._first, KEY, self.clock_s(number), incarnation, self.options.agreement
        )
        self.agents[number] = agent
        return agent

    def start(self, count: int) -> int:
        """Return the number of a start, as `fleet_start` draws it."""
        return count << 16 | int(self.random.integers(1 << 16))

    def restart(self, number: int, kind: str) -> None:
        """Start an agent again that has died, or one beside it."""
        if self.vehicles[number] is None:
            return
        if kind == 'counted':
            self.starts[number] += 1
            self._start(number, self.start(self.starts[number]))
        elif kind == 'forgotten':
            self._start(number, self.start(1))
        elif kind == 'stale':
            self.starts[number] += 1
            agent = self._start(number, self.start(self.starts[number]))
            if number in self.kept:
                for delta in self.kept[number].ledger.deltas({}, 10**6):
                    agent.ledger.merge(delta)

    def keep(self, number: int) -> None:
        """Keep what an agent knows now, as a file would."""
        agent = self.agents[number]
        if agent is not None:
            copy = Agent(number, self._first, KEY, 0.0, agent.ledger.writer[1])
            copy.ledger.join(agent.ledger)
            self.kept[number] = copy

    def twin(self, number: int, incarnation: int) -> None:
        """Let a second agent of the same vehicle begin, which hears and sends too."""
        self.twins.append(Agent(number, self._first, KEY, self.clock_s(number), incarnation))

    def end_twins(self) -> None:
        """End the second agents."""
        self.twins.clear()

    def _step(self) -> None:
        flying, self.radio.due = self.radio.due, self._due  # type: ignore[method-assign]
        self._flying = flying
        super()._step()
        self.radio.due = flying  # type: ignore[method-assign]
        for twin in self.twins:
            now_s = self.clock_s(twin.own)
            for data in twin.advance(now_s):
                self.radio.send(twin.own, data, self.now_s)
                agent = self.agents[twin.own]
                if agent is not None:
                    agent.receive(data, now_s)
            wanted = twin.wanted
            if wanted is not None:
                twin.planned(
                    wanted, self._plans.get(wanted.proposal, wanted.coordinator, wanted.rings)
                )

    def _due(self, now_s: float) -> list[tuple[int, bytes]]:
        for receiver, data in self._flying(now_s):
            if self.random.random() < self.damage:
                bad = bytearray(data)
                bad[int(self.random.integers(len(bad)))] ^= int(self.random.integers(1, 256))
                data = bytes(bad)
            if len(self.heard) < 3000 and self.random.random() < 0.1:
                self.heard.append(data)
            targets = [a for a in (self.agents[receiver], *self.twins) if a and a.own == receiver]
            for agent in targets:
                agent.receive(data, self.clock_s(receiver))
        return []

    def replay(self) -> None:
        """Let everybody hear packets of long ago again."""
        for _ in range(min(30, len(self.heard))):
            data = self.heard[int(self.random.integers(len(self.heard)))]
            for agent in self.live:
                agent.receive(data, self.clock_s(agent.own))

    def _think(self, agent: Agent) -> None:
        if agent.own in self.failed:
            agent.disable('battery')
        self.longest = max([self.longest, *map(len, self._advance(agent))])

    def _advance(self, agent: Agent) -> list[bytes]:
        now_s, self.now_s = self.now_s, self.now_s
        wanted, number = agent.wanted, agent.own
        if wanted is not None:
            known = self._computing.get(number)
            if known is None or known[1] != wanted.epoch:
                plan = self._plans.get(wanted.proposal, wanted.coordinator, wanted.rings)
                self._computing[number] = now_s + self.options.planning_s, wanted.epoch, plan
            elif now_s >= known[0]:
                del self._computing[number]
                agent.planned(wanted, known[2])
                self._note_flying(agent)
        else:
            self._computing.pop(number, None)
        sent = agent.advance(self.clock_s(number))
        for data in sent:
            self.radio.send(number, data, now_s)
        return sent


KINDS = (
    'lose', 'kill', 'counted', 'forgotten', 'stale', 'keep', 'cut', 'cut', 'heal', 'twin',
    'replay', 'disable',
)  # fmt: skip


def schedule(trial: Hostile, kinds: Sequence[str]) -> None:
    """Draw what happens."""
    random, count = trial.random, len(trial.agents)
    spared = int(random.integers(count))
    for time_s in sorted(random.uniform(3.0, LAST_EVENT_S, int(random.integers(2, 12)))):
        kind, number = str(random.choice(kinds)), int(random.integers(count))
        trial.log.append(f'{time_s:.1f} {kind} {number}')
        trial.at(float(time_s), partial(_happen, kind=kind, number=number, spared=spared))
    trial.at(LAST_EVENT_S + 1.0, _mend)


def _mend(trial: Trial) -> None:
    """Heal the radio, end twins, start again the agents of vehicles that fly."""
    trial.radio.heal()
    trial.end_twins()  # type: ignore[attr-defined]
    for number, agent in enumerate(trial.agents):
        if agent is None and trial.vehicles[number] is not None:
            trial.restart(number, 'counted')  # type: ignore[attr-defined]


def _happen(trial: Trial, kind: str, number: int, spared: int) -> None:
    if not isinstance(trial, Hostile):
        raise TypeError
    random, count = trial.random, len(trial.agents)
    if kind == 'lose' and number != spared:
        trial.lose(number)
    elif kind == 'kill':
        trial.kill_agent(number)
    elif kind in ('counted', 'forgotten', 'stale'):
        trial.kill_agent(number)
        trial.restart(number, kind)
    elif kind == 'keep':
        trial.keep(number)
    elif kind == 'cut':
        parts = random.integers(0, 3, count)
        trial.radio.cut([[k for k in range(count) if parts[k] == side] for side in range(3)])
    elif kind == 'heal':
        trial.radio.heal()
    elif kind == 'twin':
        trial.twin(number, trial.start(int(random.integers(1, 3))))
    elif kind == 'replay':
        trial.replay()
    elif kind == 'disable' and number != spared and (agent := trial.agents[number]):
        trial.failed.add(number)
        trial.vehicles[number] = None


def faults(trial: Hostile) -> list[str]:
    """Fly a trial to its end; return what should not be."""
    trial.run(lambda t: t.now_s >= LAST_EVENT_S + 2.0)
    trial.run(lambda t: _agree(t) or t.now_s >= LAST_EVENT_S + SETTLE_S)
    found = [] if _agree(trial) else ['no agreement while points are left']
    outcome = trial.run()
    begin_s = trial.now_s
    trial.run(lambda t: _know_the_same(t) or t.now_s > begin_s + SETTLE_S)
    if outcome.missing:
        found.append(f'{outcome.missing} missing')
    if trial.now_s >= trial.options.longest_s:
        found.append('does not end')
    if not _know_the_same(trial):
        found.append('ledgers differ')
    if outcome.least_m < 10.0 - 1e-6:
        found.append(f'{outcome.least_m:.1f} m apart')
    if trial.longest > MOST_BYTES:
        found.append(f'packet of {trial.longest} bytes')
    return found


def _agree(trial: Trial) -> bool:
    """Return whether all that fly keep to one plan, or nothing is left."""
    able = [a for a in trial.live if trial.vehicles[a.own] is not None]
    if not any(agent.left for agent in able):
        return True
    return len({(a.epoch, a.plan.digest) for a in able}) <= 1


def _know_the_same(trial: Trial) -> bool:
    return len({agent.ledger.digest for agent in trial.live}) <= 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Fly and print; return 1 if something was wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--first', type=int, default=0)
    parser.add_argument('--count', type=int, default=200)
    parser.add_argument('--only', nargs='*', default=KINDS, metavar='KIND')
    given = parser.parse_args(arguments)
    plan = survey(4, 5)
    plans = SharedPlans(dealt(plan))
    bad, begin_s, twice = 0, time.process_time(), 0
    for seed in range(given.first, given.first + given.count):
        trial = Hostile(plan, seed, plans)
        schedule(trial, given.only)
        try:
            found = faults(trial)
        except Exception as error:  # noqa: BLE001
            found = [repr(error)]
        twice += trial.outcome.duplicates
        if found:
            bad += 1
            print(f'seed {seed}: {", ".join(found)}; {"; ".join(trial.log)}', flush=True)
    used_s = time.process_time() - begin_s
    print(
        f'{given.count} schedules, {bad} with faults, {twice} photographed twice, {used_s:.0f} s of a core'
    )
    return 1 if bad else 0


if __name__ == '__main__':
    sys.exit(main())
