# SPDX-License-Identifier: Apache-2.0
"""Fleets in simulated time: losses, cuts, restarts, coordinators that die."""

import dataclasses

import numpy as np
import pytest

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.fleet_plan import (
    FleetPlan,
    SharedPlans,
    Wanted,
    plan_of,
    situation_of,
)
from rocsafe_fleet.agreement.options import MOST_AGENTS, MOST_POINTS
from rocsafe_fleet.ledger.ledger import Kind
from rocsafe_fleet.ledger.packet import MOST_BYTES, decode
from rocsafe_fleet.ledger.records import Proposal, place_of, ring_bytes
from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.trial import KEY, Trial, agreed
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_planner.replanning import replan

from . import surveys
from .surveys import after, trial

pytestmark = pytest.mark.slow

LOSSY = RadioOptions(loss=0.2, duplicates=0.1, jitter_s=0.3)


def test_without_a_loss_the_first_plan_is_flown():
    """No epoch begins, and all is photographed once."""
    one = trial()
    outcome = one.run()
    assert (outcome.missing, outcome.duplicates, outcome.flying_s) == (0, 0, {})


@pytest.mark.parametrize('lost', [0, 2])
def test_the_others_take_over(lost):
    """From any one that is lost, the coordinator too; soon, and nothing twice."""
    one = trial()
    one.at(20.0, lambda fleet: fleet.lose(lost))
    outcome = one.run()
    assert (outcome.missing, outcome.duplicates) == (0, 0)
    assert len(outcome.flying_s) == 1
    # Three heartbeats, a pause to gather changes, packets, and the time for the plan.
    assert max(outcome.flying_s.values()) < 20.0 + 3.0 + 1.3 + 1.0
    assert agreed(one.live)


def test_all_but_one_are_lost():
    """The last one does it all."""
    one = trial()
    for number, time_s in ((0, 10.0), (2, 11.0), (3, 40.0)):
        one.at(time_s, lambda fleet, number=number: fleet.lose(number))
    outcome = one.run()
    assert outcome.missing == 0


@pytest.mark.parametrize('seed', range(2))
def test_two_halves_meet_again(seed):
    """Own points come first: a short cut makes no duplicate; both agree soon after it."""
    one = trial(seed, radio=LOSSY)
    one.at(10.0, lambda fleet: fleet.radio.cut([[0, 1], [2, 3]]))
    one.at(30.0, lambda fleet: fleet.radio.heal())
    one.run(after(29.0))
    assert one.live[0].epoch[1] == 0
    assert one.live[3].epoch[1] == 2
    one.run(after(35.0))
    assert len({agent.epoch for agent in one.live}) == 1
    outcome = one.run()
    assert (outcome.missing, outcome.duplicates, outcome.alarms) == (0, 0, 0)


def test_a_lasting_cut_loses_nothing():
    """Each part does all in the end; the photographs of both count."""
    one = trial()
    one.at(10.0, lambda fleet: fleet.radio.cut([[0, 1], [2, 3]]))
    outcome = one.run()
    assert outcome.missing == 0
    assert outcome.duplicates > 0


@pytest.mark.parametrize('seed', range(2))
def test_coordinators_may_die_at_any_time(seed):
    """Also while they propose; those that start again take part again."""
    random = np.random.default_rng(seed)
    one = trial(seed, radio=LOSSY)
    one.at(15.0, lambda fleet: fleet.lose(3))
    moment = 15.0 + 6.0 * float(random.random())
    one.at(moment, lambda fleet: fleet.kill_agent(0))
    one.at(moment + 1.0, lambda fleet: fleet.kill_agent(1))
    one.at(moment + 9.0, lambda fleet: fleet.start_agent(0, 2))
    one.at(moment + 11.0, lambda fleet: fleet.start_agent(1, 2))
    outcome = one.run()
    assert outcome.missing == 0
    assert len({(agent.epoch, agent.plan.digest) for agent in one.live}) == 1


def test_every_proposal_is_repeated_until_its_members_have_planned():
    """Not the first alone: a member that misses the second gets it again."""
    one = trial(radio=RadioOptions())
    one.at(10.0, lambda fleet: fleet.lose(3))
    one.at(20.0, lambda fleet: fleet.lose(2))
    one.run(after(23.0))
    assert {agent.epoch[0] for agent in one.live} == {1}
    told = []
    send, receive = one.radio.send, one.agents[1].receive

    def count(sender, data, now_s):
        told.extend(
            d
            for d in decode(data, KEY).deltas
            if any(e.key[:2] == ((0, 1), Kind.PROPOSAL) for e in d.entries)
        )
        send(sender, data, now_s)

    one.radio.send = count
    one.agents[1].receive = lambda data, now_s: receive(data, now_s) if len(told) > 1 else None
    one.run(after(26.0))
    assert len(told) > 1
    assert {agent.epoch[0] for agent in one.live} == {2}


def test_an_agent_that_forgot_its_starts_takes_part_again():
    """Its number is below that of the start before, which the others still tell."""
    one = trial()
    for time_s, start in ((12.0, 9), (15.0, 5)):
        one.at(time_s, lambda fleet: fleet.kill_agent(1))
        one.at(time_s + 1.0, lambda fleet, start=start: fleet.start_agent(1, start))
    one.run(after(22.0))
    assert {frozenset(agent.live) for agent in one.live} == {frozenset(range(4))}
    outcome = one.run()
    assert outcome.missing == 0
    assert len({agent.ledger.digest for agent in one.live}) == 1


def test_a_loss_that_is_announced_frees_its_points():
    """Nobody waits for three heartbeats, and its viewpoints need not come last."""
    one = trial()

    def end(fleet: Trial) -> None:
        fleet.agents[2].disable('battery')
        fleet.vehicles[2] = None

    one.at(20.0, end)
    outcome = one.run()
    assert outcome.missing == 0
    assert min(outcome.flying_s.values()) < 22.0
    assert not one.live[0].proposal.last
    assert one.live[0].knowledge.unable == {2: 'battery'}


def test_a_zone_changes_the_plan():
    """A zone that one agent learns of is kept by all."""
    one = trial()
    middle = offset(surveys.CORNER, 50.0, 50.0)
    corners = [offset(middle, east, north) for east, north in ((-15, -15), (15, -15), (0, 15))]
    one.at(12.0, lambda fleet: fleet.agents[1].ledger.write(Kind.EXCLUSION, ring_bytes(corners)))
    outcome = one.run()
    assert {agent.epoch for agent in one.live} == {(1, 0, 1)}
    assert one.live[0].proposal.exclusions == ((1, 0),)
    assert 0 < outcome.missing == len(one.live[0].plan.left_out)


def test_who_computes_another_plan_is_left_to_itself():
    """A version that plans otherwise is an alarm; its points come last for the others."""
    one = trial()
    right = surveys.plans()

    def wrong(wanted: Wanted) -> FleetPlan:
        plan = right.get(wanted)
        routes = {k: tuple(reversed(route)) for k, route in plan.routes.items()}
        return dataclasses.replace(plan, routes=routes)

    skewed = SharedPlans(wrong)
    think = one._think

    def think_skewed(agent: Agent) -> None:
        one._plans = skewed if agent.own == 2 else right
        think(agent)

    one._think = think_skewed
    one.at(15.0, lambda fleet: fleet.lose(3))
    outcome = one.run()
    assert outcome.missing == 0
    assert outcome.alarms > 0
    assert 2 not in one.live[0].proposal.names


@pytest.mark.parametrize('seed', range(2))
def test_parts_with_different_plans_never_meet(seed):
    """Layers belong to vehicles: whatever the parts plan, they stay apart on their way."""
    random = np.random.default_rng(seed)
    one = trial(seed, radio=LOSSY)
    for time_s in sorted(random.uniform(5.0, 60.0, 4)):
        parts = random.integers(0, 2, 4)
        groups = [[k for k in range(4) if parts[k] == side] for side in (0, 1)]
        one.at(float(time_s), lambda fleet, groups=groups: fleet.radio.cut(groups))
    outcome = one.run()
    assert outcome.missing == 0
    assert outcome.least_m >= 10.0 - 1e-6


def test_who_lands_is_in_the_next_plan_when_it_stands():
    """It takes no route before: a plan would take it for one that flies on from where it is."""
    one = trial()
    one.run(lambda fleet: fleet.vehicles[3].place(fleet.now_s).is_landing)
    begin_s = one.now_s
    for number in range(3):
        one.lose(number)
    one.run(after(begin_s + 40.0))
    assert one.vehicles[3].is_aloft
    assert one.agents[3].proposal.number == 0
    one.run(lambda fleet: fleet.agents[3].proposal.number > 0)
    assert one.run().missing == 0
    ((number, place),) = one.agents[3].proposal.members
    assert (number, place.is_aloft, place.is_landing) == (3, False, False)


def test_a_plan_by_insertion_covers_the_same_points():
    """What is planned without compiled code leaves nothing out, and keeps last points last."""
    one = trial()
    one.at(15.0, lambda fleet: fleet.lose(1))
    one.run(after(25.0))
    agent = one.live[0]
    wanted = Wanted(proposal=agent.proposal, coordinator=agent.epoch[1:])
    found = plan_of(one.survey, wanted)
    assert found.routes == agent.plan.routes
    rest = replan(one.survey, situation_of(one.survey, wanted), method='insertion')
    flown = [view.id for route in rest.routes for view in route.viewpoints]
    assert sorted(flown) == sorted(p for route in found.routes.values() for p in route)
    for route in rest.routes:
        is_last = [view.id in agent.proposal.last for view in route.viewpoints]
        assert is_last == sorted(is_last)
    best = agent.plan.source
    assert best is not None
    assert rest.makespan_s < 1.4 * best.makespan_s


def test_a_fleet_that_is_too_large_is_refused():
    """One packet must hold a proposal."""
    first = FleetPlan(routes={k: (k,) for k in range(MOST_AGENTS + 1)})
    with pytest.raises(ValueError, match='must be at most 20'):
        Agent(0, first, b'', 0.0)


def test_packets_stay_below_one_frame():
    """Also those of the largest fleet with most viewpoints, of which half are photographed."""
    share = MOST_POINTS // MOST_AGENTS
    starts = range(0, share * MOST_AGENTS, share)
    first = FleetPlan(routes={k: tuple(range(p, p + share)) for k, p in enumerate(starts)})
    agents = [Agent(k, first, b'', 0.0, 9 << 16) for k in range(MOST_AGENTS)]
    place = surveys.survey().routes[0].viewpoints[0].position
    longest = 0
    for tick in range(60):
        now_s = 0.1 * tick
        packets = []
        for agent in agents[: -1 if tick > 10 else None]:
            agent.move(place_of(place, 100.0, is_aloft=True))
            agent.visit(first.routes[agent.own][: share // 2])
            packets += agent.advance(now_s)
        for data in packets:
            longest = max(longest, len(data))
            for agent in agents[:-1]:
                agent.receive(data, now_s)
    assert agents[0].wanted is not None
    assert agents[10].wanted == agents[0].wanted
    assert longest <= 1200


def test_the_longest_proposal_fits_into_a_packet():
    """Places far from the origin, all viewpoints either done or last, and eight zones."""
    place = place_of(GeoPosition(-53.28, -179.06, 4000.0), 9000.0, is_aloft=True)
    proposal = Proposal(
        number=200,
        members=tuple((k, place) for k in range(MOST_AGENTS - 1)),
        silent=frozenset({MOST_AGENTS - 1}),
        visited=frozenset(range(0, MOST_POINTS, 2)),
        last=frozenset(range(1, MOST_POINTS, 2)),
        exclusions=tuple((k, 1) for k in range(8)),
    )
    agent = Agent(0, FleetPlan(routes={k: (k,) for k in range(MOST_AGENTS)}), KEY, 0.0, 9 << 16)
    agent.advance(0.0)
    agent.ledger.write(Kind.PROPOSAL, proposal.encoded())
    (data,) = agent.advance(1.0)
    assert len(data) <= MOST_BYTES
    assert any(e.key[1] == Kind.PROPOSAL for d in decode(data, KEY).deltas for e in d.entries)


def test_points_of_a_vehicle_that_is_heard_again_are_no_longer_last():
    """Only those of vehicles that are silent still."""
    one = trial()
    one.at(8.0, lambda fleet: fleet.radio.cut([[0, 1], [2], [3]]))
    one.at(14.0, lambda fleet: fleet.radio.cut([[0, 1, 2], [3]]))
    one.run(after(19.0))
    proposal = one.live[0].proposal
    assert (proposal.names, proposal.silent) == ({0, 1, 2}, {3})
    theirs = {view.id for view in one.survey.routes[3].viewpoints}
    assert proposal.last == theirs - proposal.visited


def test_a_plan_that_a_silent_vehicle_never_claimed_leaves_its_own_route_to_it():
    """Cut off while a plan for it was under way, it flies the one before: no duplicates."""
    one = trial(radio=RadioOptions())
    one.at(10.0, lambda fleet: fleet.radio.cut([[0, 1, 2], [3]]))
    one.at(40.0, lambda fleet: fleet.radio.heal())
    one.run(after(12.0))
    # It says how it is, and hears nothing.
    one.agents[2].receive = lambda _data, _now_s: None
    one.run(lambda fleet: fleet.agents[0].wanted is not None)
    one.radio.cut([[0, 1], [2, 3]])
    one.run(after(15.0))
    del one.agents[2].receive
    assert (one.agents[0].proposal.names, one.agents[2].epoch[0]) == ({0, 1, 2}, 0)
    one.run(after(19.0))
    proposal = one.agents[0].proposal
    assert proposal.silent == {2, 3}
    theirs = {view.id for k in (2, 3) for view in one.survey.routes[k].viewpoints}
    assert proposal.last >= theirs - proposal.visited
    assert (one.run().duplicates, one.outcome.missing) == (0, 0)


def test_those_that_are_cut_off_together_are_missed_together():
    """Who is overdue is waited for: one proposal, not one a vehicle."""
    one = trial(radio=RadioOptions())
    # Vehicle 3 is heard for the last time a second before vehicle 2.
    one.at(9.0, lambda fleet: fleet.radio.cut([[0, 1, 2], [3]]))
    one.at(10.0, lambda fleet: fleet.radio.cut([[0, 1], [2, 3]]))
    one.run(after(16.0))
    assert {(agent.epoch[0], agent.proposal.silent) for agent in one.live[:2]} == {
        (1, frozenset({2, 3}))
    }
