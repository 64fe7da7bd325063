# SPDX-License-Identifier: Apache-2.0
"""Fleets without a head: `python benchmarks/fleet.py [--seeds N] [PART ...]`.

All parts fly whole missions in simulated time over a simulated radio. Times are simulated seconds.

* `loss`: any one of 5 drones with 400 viewpoints is lost: when the others fly new routes, and how
  their makespan compares with a central search of ten seconds from the same moment. A loss that is
  announced frees its viewpoints at once; those of a silent vehicle come last.
* `missions`: many small missions with random losses over a bad radio: viewpoints lost.
* `partition`: 5 drones split 2 + 3 for 120 s under 20 % loss.
* `coordinator`: the coordinator dies at random moments around its proposal.
* `thin`: 9.6 kbit/s a vehicle and 50 % loss: time until all agree, and bytes.
* `half`: half of the drones are lost.
* `peers`: CBBA, PI and an auction by insertion share what a lost drone leaves, with the same
  places and the same losses of messages (`fleet_peers.py`): longest way over that of a search of
  three seconds that knows everything, messages, and points that nobody or more than one has.
"""

import argparse
import math
import statistics
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np
from fleet_peers import LINKS, METHODS, Link, Work, judged
from replanning import CAMERA, CORNER

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.fleet_plan import SharedPlans, Wanted, situation_of
from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.trial import Trial, TrialOptions, agreed, planner_of
from rocsafe_fleet.trial.what_if import central_s
from rocsafe_geo.position import level_offset_m, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import CoverageOptions, Effort, SeparationOptions
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.replanning import remaining_request

BAD = RadioOptions(loss=0.2, duplicates=0.05, jitter_s=0.2)
BURSTS = RadioOptions(burst=(0.05, 0.3), jitter_s=0.2)
THIN = RadioOptions(loss=0.5, bits_per_s=9600.0, jitter_s=0.1)
PEER_SEARCH_S = 3.0
Seed = int


def survey(fleet: int, side: int, effort: Effort | None = None) -> SurveyPlan:
    """Return the plan of a square of `side` by `side` viewpoints, 20 m apart."""
    size = 20.0 * side
    corners = ((0, 0), (size, 0), (size, size), (0, size))
    area = SurveyArea(tuple(offset(CORNER, east - 10, north - 10) for east, north in corners))
    homes = [offset(CORNER, 15.0 * k, -30.0) for k in range(fleet)]
    return plan_survey(
        SurveyRequest(
            regions=(SurveyRegion(area=area),),
            camera=CAMERA,
            vehicles=tuple(
                Vehicle(name=f'rav{k}', home=home, endurance_s=1e5) for k, home in enumerate(homes)
            ),
            coverage=CoverageOptions(height_agl_m=32.0),
            separation=SeparationOptions(distance_m=5.0 if fleet > 9 else 10.0, by='reserved'),
            effort=effort or Effort(),
        )
    )


@dataclass(frozen=True)
class Field:
    """A survey and the plans of its epochs, which all trials share."""

    plan: SurveyPlan
    plans: SharedPlans

    def trial(self, seed: Seed, radio: RadioOptions | None = None, step_s: float = 0.1) -> Trial:
        """Return a fleet that is about to take off."""
        options = TrialOptions(radio=radio or RadioOptions(), step_s=step_s)
        return Trial(self.plan, options, np.random.default_rng(seed), self.plans)


def field(fleet: int, side: int) -> Field:
    """Return a survey, planned."""
    plan = survey(fleet, side)
    return Field(plan, SharedPlans(planner_of(plan)))


def reached(condition: Callable[[Trial], bool], longest_s: float) -> Callable[[Trial], bool]:
    """Return whether a trial fulfils a condition, or so much time has passed since now."""
    begin: list[float] = []

    def is_over(trial: Trial) -> bool:
        begin.append(trial.now_s) if not begin else None
        return condition(trial) or trial.now_s - begin[0] >= longest_s

    return is_over


def _at(time_s: float) -> Callable[[Trial], bool]:
    """Return whether a trial has come to a time."""
    return lambda trial: trial.now_s >= time_s


def _cut(trial: Trial, groups: list[list[int]]) -> None:
    trial.radio.cut(groups)


def say(name: str, value: str, target: str, is_met: bool) -> bool:
    """Print a row."""
    print(f'{name:44s} {value:>26s}   {target:>22s}  {"met" if is_met else "MISSED"}', flush=True)
    return is_met


def loss(seeds: int) -> bool:
    """Lose one of five drones with 400 viewpoints."""
    place, delays, missing = field(5, 20), [], 0
    excess: dict[str, list[float]] = {'announced': [], 'silent': []}
    for seed in range(max(2, seeds // 20)):
        random = np.random.default_rng(seed)
        lost, time_s = int(random.integers(5)), float(random.uniform(50.0, 500.0))
        for kind, found in excess.items():
            trial = place.trial(seed, step_s=0.05)
            trial.at(time_s, partial(_lose, number=lost, announced=kind == 'announced'))
            outcome = trial.run()
            missing += outcome.missing
            agent = trial.live[0]
            delays.append(min(outcome.flying_s.values()) - time_s)
            if kind == 'silent':
                delays[-1] -= 3.0
            found.append(outcome.makespan_s / central_s(trial, _wanted(agent), 10.0) - 1.0)
    slowest = float(np.quantile(delays, 0.99))
    is_met = say('new routes after detection, p99', f'{slowest:.2f} s', '<= 1.0 s', slowest <= 1.0)
    for kind, found in excess.items():
        text = f'{100 * statistics.mean(found):+.2f} %, worst {100 * max(found):+.2f} %'
        is_met &= say(f'makespan over central, {kind}', text, '<= +2 %', max(found) <= 0.02)
    return say('viewpoints lost', str(missing), '0', missing == 0) and is_met


def _wanted(agent: Agent) -> Wanted:
    """Return what the plan of an agent was made from."""
    return Wanted(proposal=agent.proposal, coordinator=agent.epoch[1:])


def _lose(trial: Trial, number: int, *, announced: bool) -> None:
    if announced:
        agent = trial.agents[number]
        if agent is not None:
            agent.disable('battery')
        trial.vehicles[number] = None
    else:
        trial.lose(number)


def missions(seeds: int) -> bool:
    """Fly many small missions with random losses and restarts over a bad radio."""
    place, missing, duplicates, least = field(4, 5), 0, 0, math.inf
    for seed in range(seeds):
        random = np.random.default_rng(seed)
        trial = place.trial(seed, BAD if seed % 2 else BURSTS, step_s=0.2)
        order = random.permutation(4)
        trial.at(float(random.uniform(5, 60)), partial(Trial.lose, number=int(order[0])))
        when = float(random.uniform(5, 60))
        trial.at(when, partial(Trial.kill_agent, number=int(order[1])))
        trial.at(when + 8.0, partial(Trial.start_agent, number=int(order[1]), incarnation=2))
        outcome = trial.run()
        missing += outcome.missing
        duplicates += outcome.duplicates
        least = min(least, outcome.least_m)
    is_met = say(f'viewpoints lost in {seeds} missions', str(missing), '0', missing == 0)
    print(f'{"  photographed twice, a mission":44s} {duplicates / seeds:26.2f}')
    return say('least distance', f'{least:.1f} m', '>= 10 m', least >= 10.0 - 1e-6) and is_met


def partition(seeds: int) -> bool:
    """Split five drones 2 + 3 for 120 s under 20 % loss."""
    place, twice, agreements, least, missing = field(5, 12), [], [], math.inf, 0
    for seed in range(max(3, seeds // 10)):
        trial = place.trial(seed, RadioOptions(loss=0.2))
        random = np.random.default_rng(seed)
        begin, parts = float(random.uniform(20, 60)), random.permutation(5)
        groups = [parts[:2].tolist(), parts[2:].tolist()]
        trial.at(begin, partial(_cut, groups=groups))
        trial.at(begin + 120.0, lambda t: t.radio.heal())
        trial.run(_at(begin + 120.0))
        trial.run(reached(_same_plan, 30.0))
        agreements.append(trial.now_s - begin - 120.0)
        outcome = trial.run()
        twice.append(outcome.duplicates)
        missing += outcome.missing
        least = min(least, outcome.least_m)
    worst = max(agreements)
    text = f'{statistics.median(agreements):.1f} s, worst {worst:.1f} s'
    is_met = say('agreement after healing', text, '<= 2 s', worst <= 2.0)
    is_met &= say('photographed twice', str(sum(twice)), '0', not any(twice))
    is_met &= say('viewpoints lost', str(missing), '0', missing == 0)
    return say('least distance', f'{least:.1f} m', '>= 10 m', least >= 10.0 - 1e-6) and is_met


def _same_plan(trial: Trial) -> bool:
    """Return whether all agents keep to one plan with all of them as members."""
    epochs = {(agent.epoch, agent.plan.digest) for agent in trial.live}
    return len(epochs) == 1 and trial.live[0].proposal.names == {a.own for a in trial.live}


def coordinator(seeds: int) -> bool:
    """Let the coordinator die at a random moment around its proposal."""
    place, stuck, differing = field(4, 5), 0, 0
    for seed in range(seeds):
        trial = place.trial(seed, BAD)
        random = np.random.default_rng(seed)
        trial.at(20.0, lambda t: t.lose(3))
        # The proposal comes 3.2 s after the loss, its plan 0.7 s later.
        moment = 20.0 + float(random.uniform(2.9, 4.9))
        trial.at(moment, lambda t: t.kill_agent(0))
        if seed % 2:
            trial.at(moment + float(random.uniform(0.2, 6.0)), lambda t: t.start_agent(0, 2))
        trial.run(_at(40.0))
        trial.run(reached(lambda t: agreed(t.live) and not t.outcome.alarms, 20.0))
        stuck += any(agent.wanted is not None for agent in trial.live)
        differing += len({(agent.epoch, agent.plan.digest) for agent in trial.live}) > 1
    is_met = say(f'epochs stuck after {seeds} deaths', str(stuck), '0', stuck == 0)
    return say('plans that differ at the end', str(differing), '0', differing == 0) and is_met


def thin(seeds: int) -> bool:
    """Let ten drones agree over 9.6 kbit/s with 50 % loss; count bytes."""
    place, times = field(10, 10), []
    for seed in range(max(3, seeds // 20)):
        trial = place.trial(seed, THIN, step_s=0.2)
        trial.at(40.0, lambda t: t.lose(4))
        trial.run(_at(43.0))
        trial.run(reached(_same_plan, 60.0))
        times.append(trial.now_s - 43.0)
    worst = max(times)
    is_met = say('agreement at 9.6 kbit/s, 50 % loss', f'{worst:.1f} s', '<= 30 s', worst <= 30.0)
    trial = place.trial(0)
    trial.run(_at(20.0))
    # Vehicles that stand: no news, heartbeats only.
    trial.vehicles = [None] * 10
    before = list(trial.radio.payload_bytes)
    trial.run(_at(50.0))
    steady = max(b - a for a, b in zip(before, trial.radio.payload_bytes, strict=True)) / 30.0
    is_met &= say('payload, steady, 10 drones', f'{steady:.0f} B/s', '<= 250 B/s', steady <= 250.0)
    before = list(trial.radio.payload_bytes)
    trial.lose(4)
    trial.run(_at(65.0))
    spent = [b - a for a, b in zip(before, trial.radio.payload_bytes, strict=True)]
    event = max(spent) - 15.0 * steady
    return say('payload, a loss', f'{event:.0f} B', '<= 2000 B', event <= 2000.0) and is_met


def half(seeds: int) -> bool:
    """Lose half of the drones at random times."""
    place, missing, count = field(6, 6), 0, max(3, seeds // 4)
    for seed in range(count):
        random = np.random.default_rng(seed)
        trial = place.trial(seed, BAD, step_s=0.2)
        for lost in random.permutation(6)[:3]:
            trial.at(float(random.uniform(5, 60)), partial(Trial.lose, number=int(lost)))
        missing += trial.run().missing
    return say(f'viewpoints lost, {count} missions, half lost', str(missing), '0', missing == 0)


def peers(seeds: int) -> bool:
    """Compare with published methods: 5 to 20 agents, 0 to 90 % loss, two kinds of it."""
    print(f'{"agents, loss":26s}' + ''.join(f'{name:>30s}' for name in ('ours', *METHODS)))
    is_best = True
    for fleet, (kind, links) in product((5, 10, 20), LINKS.items()):
        place = field(fleet, 10)
        for percent in (0, 30, 60, 90) if seeds < 50 else range(0, 100, 10):
            rows: dict[str, list[Row]] = {}
            for seed in range(max(1, seeds // 20)):
                for name, row in _compared(place, links, kind, percent / 100, seed).items():
                    rows.setdefault(name, []).append(row)
            means = {name: np.mean(found, axis=0) for name, found in rows.items()}
            cells = [f'{100 * m[0]:+.0f} %, {m[1]:.0f} msg, {m[2]:.1f}' for m in means.values()]
            print(f'{f"{fleet}, {kind} {percent} %":26s}' + ''.join(f'{c:>30s}' for c in cells))
            is_best &= all(means['ours'][0] <= m[0] + 0.02 for m in means.values())
    print('longest way over the central one, messages, points that nobody or several have')
    return is_best


Row = tuple[float, float, float]


def _compared(place: Field, links: Link, kind: str, mean: float, seed: Seed) -> dict[str, Row]:
    """Return what each method makes of the same loss of a drone."""
    random = np.random.default_rng(seed)
    fleet = len(place.plan.routes)
    lost, time_s = int(random.integers(1, fleet)), float(random.uniform(20.0, 40.0))
    to_good = min(0.3, (1.0 - mean) / max(mean, 1e-9))
    burst = (to_good * mean / (1.0 - mean), to_good)
    radio = RadioOptions(loss=mean) if kind == 'Bernoulli' else RadioOptions(burst=burst)
    trial = place.trial(seed, radio)
    trial.run(_at(time_s))
    _lose(trial, lost, announced=True)
    sent = sum(trial.radio.packets)
    trial.run(reached(partial(_has_shared, lost=lost), 180.0))
    messages = sum(trial.radio.packets) - sent
    agent = max(trial.live, key=lambda one: one.epoch)
    work, numbers, order = _work(place, agent)
    paths = [[order[p] for p in agent.plan.routes[k] if p in order] for k in numbers]
    found = {'ours': judged(work, paths, messages)}
    for name, method in METHODS.items():
        found[name] = method(work, links(mean, np.random.default_rng(seed)))
    best = central_m(place, agent, work, numbers, order)
    return {
        name: (one.longest_m / best - 1.0, one.messages, one.unassigned + one.twice)
        for name, one in found.items()
    }


def _has_shared(trial: Trial, lost: int) -> bool:
    epochs = {(agent.epoch, agent.plan.digest) for agent in trial.live}
    names = trial.live[0].proposal.names
    return len(epochs) == 1 and bool(names) and lost not in names


def _work(place: Field, agent: Agent) -> tuple[Work, list[int], dict[int, int]]:
    """Return what is left in an agent's epoch, as the published methods take it."""
    origin = place.plan.request.regions[0].area.centroid()
    views = [view for route in place.plan.routes for view in route.viewpoints]
    left = [view for view in views if view.id not in agent.proposal.visited]
    members = agent.proposal.members
    homes = [place.plan.request.vehicles[k].home for k, _ in members]
    work = Work(
        starts=np.array([level_offset_m(origin, one.position) for _, one in members]),
        points=np.array([level_offset_m(origin, view.position) for view in left]),
        homes=np.array([level_offset_m(origin, home) for home in homes]),
    )
    return work, [k for k, _ in members], {view.id: n for n, view in enumerate(left)}


def central_m(
    place: Field, agent: Agent, work: Work, numbers: list[int], order: dict[int, int]
) -> float:
    """Return the longest way of a plan of one head that searches for `PEER_SEARCH_S`."""
    names = [vehicle.name for vehicle in place.plan.request.vehicles]
    request = remaining_request(place.plan, situation_of(place.plan, _wanted(agent)))
    plan = plan_survey(replace(request, effort=Effort(budget_s=PEER_SEARCH_S)))
    routes = {names.index(r.vehicle.name): [v.id for v in r.viewpoints] for r in plan.routes}
    paths = [[order[p] for p in routes.get(k, ())] for k in numbers]
    return judged(work, paths, 0).longest_m


PARTS: dict[str, Callable[[int], bool]] = {
    'loss': loss, 'missions': missions, 'partition': partition, 'coordinator': coordinator,
    'thin': thin, 'half': half, 'peers': peers,
}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; return 1 if a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('parts', nargs='*', metavar='PART', default=[])
    parser.add_argument('--seeds', type=int, default=100, help='how many; parts take a share')
    given = parser.parse_args(arguments)
    unknown = sorted(set(given.parts) - set(PARTS))
    if unknown:
        parser.error(f'part {unknown[0]!r}: must be of {", ".join(PARTS)}')
    results = [PARTS[name](given.seeds) for name in given.parts or PARTS]
    return 0 if all(results) else 1


if __name__ == '__main__':
    sys.exit(main())
