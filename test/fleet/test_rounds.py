# SPDX-License-Identifier: Apache-2.0
"""Search after the survey: agents agree on places to measure at, whoever fails meanwhile."""

import math
from collections import Counter
from functools import lru_cache
from itertools import chain

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.batteries import Batteries, Battery
from rocsafe_fleet.agreement.fleet_plan import SharedPlans, first_plan
from rocsafe_fleet.ledger.ledger import Kind, Ledger
from rocsafe_fleet.ledger.packet import MOST_BYTES
from rocsafe_fleet.ledger.readings import DoseReading, ReadingSums, readings_of
from rocsafe_fleet.ledger.records import set_bytes, set_of
from rocsafe_fleet.search.round_chooser import RoundChooser, SearchOptions
from rocsafe_fleet.search.search_round import (
    MOST_PLACES,
    MOST_ROUNDS,
    SearchRound,
    extra_places,
    search_round_of,
)
from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.trial import KEY, TrialOptions, agreed, planner_of
from rocsafe_geo.position import GeoPosition, level_offset_m, offset
from rocsafe_radiation.localizer_options import LocalizerOptions

from . import surveys
from .search_trial import SearchTrial, TrialSearch
from .surveys import CORNER

LOSSY = RadioOptions(loss=0.2, duplicates=0.1, jitter_s=0.3)
LOW = GeoPosition(CORNER.latitude_deg, CORNER.longitude_deg, 0.0)
SOURCE = offset(CORNER, 42.0, 67.0)
PLACES, ROUNDS = 4, 2


def rate_usvh(position: GeoPosition, strength: float = 4600.0) -> float:
    """Return the dose rate of a source and of the background."""
    east, north = level_offset_m(SOURCE, position)
    up = position.altitude_m - 0.5
    return 0.06 + strength / (east**2 + north**2 + up**2)


def options(**changes: float) -> SearchOptions:
    """Return a search that is never content."""
    values = {'ellipse_95_m': 0.01, **changes}
    localizer = LocalizerOptions(
        origin_latitude_deg=CORNER.latitude_deg,
        origin_longitude_deg=CORNER.longitude_deg,
        model='paper',
        **values,
    )
    return SearchOptions(extra_rounds=ROUNDS, viewpoints_a_round=PLACES, localizer=localizer)


def chooser(**changes: float) -> RoundChooser:
    """Return what chooses places in the square of the tests."""
    return RoundChooser(options(**changes), surveys.survey().request.regions[0].area)


def spread(number: int, readings) -> SearchRound:
    """Choose places without an estimator: they follow from the readings, and cost no time."""
    seed = hash(tuple(one.dose_rate_usvh for _, one in readings)) % 2**32
    random = np.random.default_rng([number, seed])
    ways = random.uniform(0.0, 100.0, (PLACES, 2)).tolist()
    places = tuple(offset(CORNER, east, north) for east, north in ways)
    return SearchRound(number=number, places=places, reason='a test')


def trial(
    seed: int = 0, radio: RadioOptions | None = None, choose=spread, plans=None
) -> SearchTrial:
    """Return a fleet of four that searches after the survey."""
    flown = TrialOptions(radio=radio or RadioOptions(), step_s=0.2, longest_s=2000.0)
    search = TrialSearch(rounds=ROUNDS, choose=choose, rate_usvh=rate_usvh)
    plan = surveys.survey()
    random = np.random.default_rng(seed)
    return SearchTrial(plan, flown, random, plans or surveys.plans(), search)


def first_choice(one: SearchTrial, longest_s: float = 400.0) -> float:
    """Fly until the first round is chosen; return when that was."""
    one.run(lambda fleet: bool(fleet.choices) or fleet.now_s > longest_s)
    assert one.choices
    return one.now_s


@lru_cache
def lossy_choice_s(seed: int) -> float:
    """Return when the fleet of a seed, by lossy radio, chooses its first round."""
    return first_choice(trial(seed, LOSSY))


def settled(one: SearchTrial) -> bool:
    """Return whether all agents come to know the same soon after the end."""
    end_s = one.now_s + 45.0
    one.run(lambda fleet: agreed(fleet.live) or fleet.now_s > end_s)
    return agreed(one.live)


def measured(strength: float = 4600.0) -> list[Ledger]:
    """Return ledgers of two vehicles that have read over the square."""
    ledgers = [Ledger((k, 1)) for k in range(2)]
    for k, ledger in enumerate(ledgers):
        sums = ReadingSums(ledger)
        for step in range(150):
            east, north = 5.0 * (step % 25), 20.0 * (step // 25) + 10.0 * k
            place = offset(LOW, east, north, 32.0)
            rate = rate_usvh(place, strength)
            counts = round(550.0 * rate)
            sums.add(
                DoseReading(
                    position=place, dose_rate_usvh=rate, std_usvh=math.sqrt(counts) / 550.0,
                    counts=counts, live_time_s=1.0, time_s=float(step),
                )
            )  # fmt: skip
        sums.close()
    return ledgers


@given(st.frozensets(st.integers(0, 45_000), max_size=80))
def test_sets_of_far_numbers_are_short(members):
    """Places of the search have numbers far above those of the survey."""
    value = set_bytes(members)
    assert set_of(value) == members
    assert len(value) <= 2 + 6 * len(members)


def test_the_largest_round_fits_into_a_packet():
    """With places that are a kilometre apart, and a long reason."""
    ways = np.random.default_rng(0).uniform(-500.0, 500.0, (MOST_PLACES, 2)).tolist()
    places = tuple(offset(CORNER, east, north) for east, north in ways)
    one = SearchRound(number=MOST_ROUNDS, places=places, reason='ö' * 500)
    value = one.encoded()
    assert len(value) < 0.65 * MOST_BYTES
    again = search_round_of(MOST_ROUNDS, value)
    assert again.encoded() == value
    for place, read in zip(places, again.places, strict=True):
        assert math.dist((0.0, 0.0), level_offset_m(place, read)) < 0.02


def test_no_two_rounds_share_a_number():
    """Whoever chose them."""
    places = (CORNER,) * MOST_PLACES
    numbers = [
        point
        for agent in range(20)
        for number in range(1, MOST_ROUNDS + 1)
        for point, _ in extra_places(
            SearchRound(number=number, places=places, reason=''), agent, 2400
        )
    ]
    assert len(set(numbers)) == len(numbers)
    assert min(numbers) >= 2400


@pytest.mark.slow
def test_equal_ledgers_give_equal_places():
    """In whatever order they came to know the readings, and on any machine that merges them."""
    one, other = measured()
    chosen = []
    for first, second in ((one, other), (other, one)):
        merged = Ledger((7, 1))
        merged.join(first)
        merged.join(second)
        chosen.append(chooser().choose(1, readings_of([merged], ['a', 'b'])))
    assert chosen[0] == chosen[1]
    assert len(chosen[0].places) == PLACES
    assert chosen[0].reason


def test_search_ends_when_the_readings_are_enough():
    """And when there are too few of them; a round without places says why."""
    readings = readings_of(measured(strength=0.0), ['a', 'b'])
    enough, none = (chooser().choose(1, some) for some in (readings, readings[:2]))
    assert (enough.places, none.places) == ((), ())
    assert 'no source' in enough.reason
    assert 'readings' in none.reason


@pytest.mark.slow
def test_agents_fly_the_rounds_that_the_readings_ask_for():
    """With the estimator: the places lie in the region, and each is photographed once."""
    one = trial(choose=chooser().choose)
    outcome = one.run()
    assert (outcome.missing, outcome.duplicates, outcome.alarms) == (0, 0, 0)
    assert [number for _, number, _ in one.choices] == [1, 2]
    assert len(one.places) == surveys.survey().viewpoint_count + ROUNDS * PLACES
    assert settled(one)
    assert outcome.least_m >= 10.0 - 1e-6
    assert len(readings_of([one.live[0].ledger], one._names)) > 100


@pytest.mark.slow
def test_the_plan_of_a_round_is_a_partition_of_its_places():
    """All members plan it alike; a vehicle that stands takes off again."""
    one = trial()
    first_choice(one)
    one.run(lambda fleet: all(a.epoch[0] == 1 for a in fleet.live) or fleet.now_s > 500.0)
    routed = Counter(chain.from_iterable(one.live[0].plan.routes.values()))
    assert set(routed.values()) == {1}
    assert routed.keys() == one.live[0].knowledge.extra_points
    assert len({agent.plan.digest for agent in one.live}) == 1
    source = one.live[0].plan.source
    assert source is not None
    heights = [r.flight_height_m for r in source.routes if r.viewpoints]
    assert len(set(heights)) == len(heights)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('shift_s', 'seed'), [(-0.5, 0), (0.1, 1), (0.5, 0), (0.5, 1), (3.0, 1), (12.0, 0)]
)
def test_a_death_in_the_search_loses_no_place(shift_s, seed):
    """The coordinator's: while it chooses, before it proposes, and in the flight."""
    moment = lossy_choice_s(seed) + shift_s
    one = trial(seed, LOSSY)
    one.at(moment, lambda fleet: fleet.lose(0))
    outcome = one.run()
    assert (outcome.missing, outcome.alarms) == (0, 0)
    assert one.now_s < one.options.longest_s
    assert {number for _, number, _ in one.choices} == {1, 2}
    assert len({(agent.epoch, agent.plan.digest) for agent in one.live}) == 1
    assert outcome.least_m >= 10.0 - 1e-6


@pytest.mark.slow
def test_an_agent_that_begins_again_goes_on_with_the_search():
    """It knows nothing; the others tell it of the rounds."""
    seed = 1
    moment = lossy_choice_s(seed)
    one = trial(seed, LOSSY)
    one.at(moment - 0.3, lambda fleet: fleet.kill_agent(0))
    one.at(moment + 4.0, lambda fleet: fleet.start_agent(0, 2))
    outcome = one.run()
    assert (outcome.missing, outcome.alarms) == (0, 0)
    assert settled(one)


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(2))
def test_two_halves_search_by_themselves_and_meet_again(seed):
    """Both choose places from what they know; then those of both belong to all."""
    moment = lossy_choice_s(seed)
    one = trial(seed, LOSSY)
    one.at(moment - 30.0, lambda fleet: fleet.radio.cut([[0, 1], [2, 3]]))
    one.at(moment + 40.0, lambda fleet: fleet.radio.heal())
    outcome = one.run()
    choosers = {agent for agent, _, _ in one.choices}
    assert {0, 2} <= choosers
    assert (outcome.missing, outcome.alarms) == (0, 0)
    assert settled(one)
    assert outcome.least_m >= 10.0 - 1e-6


@pytest.mark.slow
@pytest.mark.parametrize('spare_s', [5.0, 45.0, 200.0])
def test_search_keeps_to_the_batteries(spare_s):
    """Places that no battery does for are left, and all end on time."""
    plan = surveys.survey()
    usable_s = max(route.duration_s for route in plan.routes) + spare_s
    names = [route.vehicle.name for route in plan.routes]
    batteries = Batteries(
        vehicles=tuple(Battery(name=n, endurance_s=1500.0, usable_s=usable_s) for n in names)
    )
    plans = SharedPlans(planner_of(batteries.freed(plan)))
    one = trial(plans=plans)
    outcome = one.run()
    assert one.now_s < one.options.longest_s
    assert max(vehicle.used_s for vehicle in one.vehicles) <= usable_s + 1.0
    left = set(chain.from_iterable(agent.plan.left_out for agent in one.live))
    errors = {agent.plan.error for agent in one.live}
    assert outcome.missing == 0 or left or errors != {''}
    assert (outcome.missing == 0) == (spare_s == 200.0)


def test_who_is_alone_without_able_vehicles_does_not_search():
    """Nobody could fly a round: the agent is done."""
    plan = first_plan(surveys.survey(1, 2))
    agent = Agent(0, plan, KEY, 0.0, rounds=1)
    agent.visit(point for route in plan.routes.values() for point in route)
    assert not agent.is_done
    agent.disable('battery')
    assert agent.is_done
    agent.advance(10.0)
    assert agent.seeks == 0


def test_rounds_of_an_agent_are_written_once():
    """A choice that comes too late changes nothing."""
    agent = Agent(0, first_plan(surveys.survey(1, 2)), KEY, 0.0, rounds=1)
    agent.decide(SearchRound(number=1, places=(CORNER,), reason='late'))
    assert agent.ledger.newest(0, Kind.ROUND, 1) is None
