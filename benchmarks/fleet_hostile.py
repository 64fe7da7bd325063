# SPDX-License-Identifier: Apache-2.0
"""Hostile schedules for agents: `python benchmarks/fleet_hostile.py [--first N] [--count N]`.

Each seed draws a radio, a fleet of 2 to 6, clocks that are wrong and drift, and some of: cuts that
change and heal in any order, ways that carry in one direction only, vehicles that are lost or
fail, agents that die and start again with nothing, with an old ledger or with the number of an
earlier start, a second agent of one vehicle, packets that are damaged or come again much later.
Half of the fleets search after the survey, two rounds of four places, and are disturbed until
then. Plans are dealt, and places drawn, by rules that cost no time, so that thousands of schedules
are flown. What must hold in each: no viewpoint is missing, all come to one plan within 45 s after
the last event while points are left, and to one ledger; vehicles stay 10 m apart; no packet is
longer than a frame; the trial ends.
"""

import argparse
import math
import sys
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from fleet import survey
from replanning import CORNER

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.fleet_plan import FleetPlan, SharedPlans, Wanted
from rocsafe_fleet.ledger.ledger import Ledger
from rocsafe_fleet.ledger.packet import MOST_BYTES
from rocsafe_fleet.ledger.readings import DoseReading, readings_of
from rocsafe_fleet.membership.identity import START_BITS
from rocsafe_fleet.search.search_round import SearchRound
from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.trial import Trial, TrialOptions
from rocsafe_geo.position import level_offset_m, offset
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.survey_options import Effort

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / 'test' / 'fleet'))
from search_trial import SearchTrial, TrialSearch

LAST_EVENT_S = 50.0
SETTLE_S = 45.0
PLACES, ROUNDS = 4, 2


def dealt(plan: SurveyPlan) -> Callable[[Wanted], FleetPlan]:
    """Return a rule that deals the viewpoints of a proposal: each to the nearest of the idlest."""
    views = {view.id: view.position for route in plan.routes for view in route.viewpoints}
    origin = plan.request.regions[0].area.centroid()
    survey_places = {number: level_offset_m(origin, where) for number, where in views.items()}

    def plan_of(wanted: Wanted) -> FleetPlan:
        proposal = wanted.proposal
        extra = {number: level_offset_m(origin, where) for number, where in wanted.extra}
        places = survey_places | extra
        at = {k: level_offset_m(origin, one.position) for k, one in proposal.members}
        routes: dict[int, list[int]] = {k: [] for k in at}
        for group in (places.keys() - proposal.visited - proposal.last, proposal.last):
            rest = set(group)
            while rest:
                idle = min(routes, key=lambda k: (len(routes[k]), k))
                here = at[idle]
                best = min(rest, key=lambda p: (math.dist(here, places[p]), p))
                rest.discard(best)
                routes[idle].append(best)
                at[idle] = places[best]
        found = {k: tuple(route) for k, route in routes.items()}
        return FleetPlan(epoch=wanted.epoch, routes=found)

    return plan_of


def drawn(number: int, readings: Sequence[tuple[str, DoseReading]]) -> SearchRound:
    """Return a round whose places follow from the readings; no estimator."""
    seed = hash(tuple(one.time_s for _, one in readings)) % 2**32
    ways = np.random.default_rng([number, seed]).uniform(0.0, 90.0, (PLACES, 2)).tolist()
    places = tuple(offset(CORNER, east, north) for east, north in ways)
    return SearchRound(number=number, places=places, reason='drawn')


class Hostile(SearchTrial):
    """A trial whose agents have clocks of their own, and a radio that damages and replays."""

    def __init__(self, plan: SurveyPlan, seed: int, plans: SharedPlans) -> None:
        self.random = random = np.random.default_rng(seed)
        radio = RadioOptions(
            loss=float(random.choice([0.0, 0.2, 0.4])),
            burst=(0.05, 0.3) if random.random() < 0.3 else (0.0, 1.0),
            duplicates=float(random.choice([0.0, 0.1])),
            jitter_s=float(random.choice([0.03, 0.3, 1.5])),
        )
        options = TrialOptions(radio=radio, step_s=0.25, longest_s=1500.0)
        rounds = ROUNDS * (seed // 3 % 2)
        search = TrialSearch(rounds=rounds, choose=drawn, rate_usvh=lambda _: 0.1)
        super().__init__(plan, options, random, plans, search)
        self.count = count = len(self.agents)
        # Those that search are disturbed until the rounds are flown.
        self.last_event_s = LAST_EVENT_S if not rounds else 1.5 * plan.makespan_s
        self.spared = int(random.integers(count))
        self.log: list[str] = []
        self.longest = 0
        self._offset_s = random.uniform(-1e5, 1e5, count)
        self._rate = 1.0 + random.uniform(-0.02, 0.02, count)
        self._starts = [1] * count
        self._twins: list[Agent] = []
        self._heard: list[bytes] = []
        self._deaf: set[tuple[int, int]] = set()
        self._kept: dict[int, Ledger] = {}
        self._failed: set[int] = set()
        self._damage = float(random.choice([0.0, 0.05]))
        loses = self.radio._loses
        self.radio._loses = (  # type: ignore[method-assign]
            lambda sender, receiver: (sender, receiver) in self._deaf or loses(sender, receiver)
        )
        for k in range(count):
            self.start_agent(k, self._start(1))

    def _start(self, count: int) -> int:
        """Return the number of a start, as `fleet_start` draws it."""
        return count << START_BITS | int(self.random.integers(1 << START_BITS))

    def _clock_s(self, number: int) -> float:
        return float(self._offset_s[number] + self._rate[number] * self.now_s)

    def _deliver(self, receiver: int, data: bytes) -> None:
        self.longest = max(self.longest, len(data))
        if self.random.random() < self._damage:
            bad = bytearray(data)
            bad[int(self.random.integers(len(bad)))] ^= int(self.random.integers(1, 256))
            data = bytes(bad)
        if len(self._heard) < 3000 and self.random.random() < 0.1:
            self._heard.append(data)
        super()._deliver(receiver, data)
        for twin in self._twins:
            if twin.own == receiver:
                twin.receive(data, self._clock_s(receiver))

    def _think(self, agent: Agent) -> None:
        if agent.own in self._failed:
            agent.disable('battery')
        super()._think(agent)

    def _step(self) -> None:
        super()._step()
        for twin in self._twins:
            now_s = self._clock_s(twin.own)
            for data in twin.advance(now_s):
                self.radio.send(twin.own, data, self.now_s)
                super()._deliver(twin.own, data)
            if twin.seeks:
                twin.decide(drawn(twin.seeks, readings_of([twin.ledger], self._names)))
            if (wanted := twin.wanted) is not None:
                twin.planned(wanted, self._plans.get(wanted))

    # What happens.

    def lost(self, number: int) -> None:
        """Lose a vehicle, but never all."""
        if number != self.spared:
            self.lose(number)

    def fails(self, number: int) -> None:
        """Let a vehicle end its flight and say so."""
        if number != self.spared:
            self._failed.add(number)
            self.vehicles[number] = None

    def counted(self, number: int) -> None:
        """Start an agent again that knows nothing."""
        self.kill_agent(number)
        if self.vehicles[number] is not None:
            self._starts[number] += 1
            self.start_agent(number, self._start(self._starts[number]))

    def forgotten(self, number: int) -> None:
        """Start an agent again that knows not even how often it has started."""
        self._starts[number] = 0
        self.counted(number)

    def stale(self, number: int) -> None:
        """Start an agent again with what was kept of its ledger before."""
        self.counted(number)
        agent, kept = self.agents[number], self._kept.get(number)
        if agent is not None and kept is not None:
            for delta in kept.deltas({}, 10**6):
                agent.ledger.merge(delta)

    def keep(self, number: int) -> None:
        """Keep what an agent knows now, as a file would."""
        if (agent := self.agents[number]) is not None:
            self._kept[number] = Ledger((99, 1))
            self._kept[number].join(agent.ledger)

    def cut(self, _: int) -> None:
        """Cut the fleet into up to three parts."""
        parts = self.random.integers(0, 3, self.count)
        sides = [[k for k in range(self.count) if parts[k] == side] for side in range(3)]
        self.radio.cut(sides)

    def deaf(self, number: int) -> None:
        """Let an agent not hear some others that may hear it."""
        others = self.random.integers(0, 2, self.count)
        self._deaf |= {(k, number) for k in range(self.count) if others[k]}

    def heal(self, _: int) -> None:
        """Let all hear each other."""
        self._deaf.clear()
        self.radio.heal()

    def twin(self, number: int) -> None:
        """Let a second agent of one vehicle begin, which hears and sends too."""
        start = self._start(int(self.random.integers(1, 3)))
        self._twins.append(self._agent(number, start, self._clock_s(number)))

    def replay(self, _: int) -> None:
        """Let everybody hear packets of long ago again."""
        for _ in range(min(30, len(self._heard))):
            data = self._heard[int(self.random.integers(len(self._heard)))]
            for number in range(self.count):
                super()._deliver(number, data)

    def mend(self) -> None:
        """Heal the radio, end second agents, start those again whose vehicles fly."""
        self.heal(0)
        self._twins.clear()
        for number, agent in enumerate(self.agents):
            if agent is None:
                self.counted(number)


KINDS: dict[str, Callable[[Hostile, int], None]] = {
    'lose': Hostile.lost, 'fail': Hostile.fails, 'kill': Trial.kill_agent,
    'counted': Hostile.counted, 'forgotten': Hostile.forgotten, 'stale': Hostile.stale,
    'keep': Hostile.keep, 'cut': Hostile.cut, 'deaf': Hostile.deaf, 'heal': Hostile.heal,
    'twin': Hostile.twin, 'replay': Hostile.replay,
}  # fmt: skip


def schedule(trial: Hostile, kinds: Sequence[str]) -> None:
    """Draw what happens."""
    random = trial.random
    for time_s in sorted(random.uniform(3.0, trial.last_event_s, int(random.integers(2, 12)))):
        kind, number = str(random.choice(list(kinds))), int(random.integers(trial.count))
        trial.log.append(f'{time_s:.1f} {kind} {number}')
        trial.at(float(time_s), partial(_happen, kind=kind, number=number))
    trial.at(trial.last_event_s + 1.0, Hostile.mend)  # type: ignore[arg-type]


def _happen(trial: Trial, kind: str, number: int) -> None:
    KINDS[kind](trial, number)  # type: ignore[arg-type]


def faults(trial: Hostile) -> list[str]:
    """Fly a trial to its end; return what should not be."""
    trial.run(lambda t: t.now_s >= trial.last_event_s + 2.0)
    trial.run(lambda t: _agree(t) or t.now_s >= trial.last_event_s + SETTLE_S)
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
    parser.add_argument('--only', nargs='*', default=list(KINDS), metavar='KIND')
    given = parser.parse_args(arguments)
    surveys = [survey(fleet, 5, effort=Effort(proposals=5000)) for fleet in (2, 4, 6)]
    plans = [SharedPlans(dealt(plan)) for plan in surveys]
    bad, begin_s, twice = 0, time.process_time(), 0
    for seed in range(given.first, given.first + given.count):
        trial = Hostile(surveys[seed % 3], seed, plans[seed % 3])
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
        f'{given.count} schedules, {bad} with faults, {twice} photographed twice, '
        f'{used_s:.0f} s of a core'
    )
    return 1 if bad else 0


if __name__ == '__main__':
    sys.exit(main())
