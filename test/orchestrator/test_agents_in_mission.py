# SPDX-License-Identifier: Apache-2.0
"""Missions with agents: the orchestrator watches, and takes over when the agents are gone."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import pytest

from rocsafe_fleet.agreement.batteries import Batteries
from rocsafe_fleet.search.round_chooser import SearchOptions
from rocsafe_geo.storage.value_file import values_of
from rocsafe_orchestrator.mission.landing import AGENTS_IDLE_S
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.presence import Sighting
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Crew, Situation
from rocsafe_orchestrator.parameters.goal_conversions import plan_goal
from rocsafe_orchestrator.parameters.node_parameters import agent_parameters, world_parameters
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario_file import read_scenario
from rocsafe_scenario.search_reserve import (
    MOST_OF_BATTERY,
    planned_endurance_s,
    search_reserve_s,
)

PROCESSES = frozenset({'planner', 'world', 'agents', 'rav1', 'rav2'})
CREW = Crew(vehicle_processes={'rav1': 'rav1', 'rav2': 'rav2'}, processes=PROCESSES)
ROUTES = tuple(Order(kind=OrderKind.FLY, vehicle=name) for name in ('rav1', 'rav2'))
AGENTS = {'fleet.agents': True, 'survey.separation.by': 'reserved'}


def airborne() -> Mission:
    """Return a mission with agents whose vehicles fly, at 101 s."""
    mission = Mission(CREW, Deadlines(), has_agents=True)
    mission.advance(100.0, Situation(ready=PROCESSES))
    mission.planned(['rav1', 'rav2'])
    mission.advance(100.1, Situation(ready=PROCESSES))
    for order in ROUTES:
        mission.accepted(order)
    mission.advance(101.0, situation())
    return mission


def situation(
    *, done: bool = False, stored: int = 0, lost: str = '', plan: bool = False
) -> Situation:
    """Return how things are during the flight."""
    return Situation(
        ready=PROCESSES,
        agents_plan=plan,
        images_stored=stored,
        images_expected=6,
        aloft=frozenset() if done else frozenset({'rav1', 'rav2'}),
        agents_are_done=done,
        sightings={
            name: Sighting(silent_s=99.0 if name == lost else 0.0, is_grounded=done)
            for name in ('rav1', 'rav2')
        },
    )


def test_a_replaced_route_and_a_loss_are_no_faults():
    """The agents give other routes; what counts is that all is photographed."""
    mission = airborne()
    mission.flown('rav2', 1, 'aborted: another plan is flown in its place')
    mission.advance(102.0, situation(lost='rav1'))
    assert mission.phase is Phase.FLYING
    assert mission.faults == []
    assert any('the agents of the others take over' in text for text in mission.remarks)


def test_a_vehicle_whose_process_is_gone_is_left_to_the_agents():
    """Simulated time does not wait for it, and that is no fault."""
    mission = airborne()
    mission.gave_up('rav1', 'was ended by SIGKILL')
    orders = mission.advance(102.0, situation())
    assert Order(kind=OrderKind.DISMISS, vehicle='rav1') in orders
    assert mission.phase is Phase.FLYING
    assert mission.faults == []


def test_a_loss_while_the_others_are_silent_for_a_moment_does_not_hang_the_mission():
    """The flight is over when the agents have done all."""
    mission = airborne()
    mission.flown('rav2', 3)
    late, gone = Sighting(silent_s=6.0), Sighting(silent_s=99.0)
    both = {'rav1': gone, 'rav2': late}
    mission.advance(102.0, dataclasses.replace(situation(), sightings=both))
    mission.advance(103.0, situation(lost='rav1'))
    for now_s in (110.0, 120.0):
        mission.advance(now_s, situation(done=True, lost='rav1', stored=6))
    assert mission.phase >= Phase.COLLECTING
    assert mission.faults == []


def test_the_flight_is_over_when_the_agents_are_done():
    """For some seconds, because a loss may give them more; then missing photographs count."""
    mission = airborne()
    for vehicle in ('rav1', 'rav2'):
        mission.flown(vehicle, 3)
    mission.advance(110.0, situation())
    mission.advance(111.0, situation(done=True))
    mission.advance(113.0, situation())
    mission.advance(114.0, situation(done=True))
    assert mission.phase is Phase.FLYING
    mission.advance(117.1, situation(done=True, stored=5))
    assert mission.phase is Phase.COLLECTING
    mission.advance(118.0, situation(done=True, stored=5))
    assert mission.phase is Phase.COLLECTING
    mission.advance(119.0, situation(done=True, stored=6))
    assert mission.phase is Phase.MAPPING
    assert mission.faults == []


def test_agents_that_leave_their_vehicles_standing_are_not_waited_for_for_ever():
    """The mission goes on to its map, with a fault."""
    mission = airborne()
    mission.answered(Order(kind=OrderKind.RUN_CLOCK))
    for vehicle in ('rav1', 'rav2'):
        mission.flown(vehicle, 3)

    def stand(now_s: float) -> None:
        mission.advance(
            now_s, dataclasses.replace(situation(), aloft=frozenset(), simulated_s=now_s)
        )

    stand(110.0)
    stand(110.0 + 0.9 * AGENTS_IDLE_S)
    assert mission.phase is Phase.FLYING
    stand(110.0 + 1.1 * AGENTS_IDLE_S)
    assert mission.phase is Phase.COLLECTING
    assert any('although agents have something to fly' in text for text in mission.faults)


def test_time_stands_still_while_agents_plan():
    """A choice of places may take long; but not longer than a plan may."""
    mission = airborne()
    mission.answered(Order(kind=OrderKind.RUN_CLOCK))
    mission.advance(102.0, dataclasses.replace(situation(), simulated_s=1.0))
    limit_s = Deadlines().plan_s
    for now_s in (103.0, 103.0 + 0.9 * limit_s):
        assert mission.advance(now_s, situation(plan=True)) == []
        assert mission.stalled_s == 0.0
    mission.advance(103.0 + 1.1 * limit_s, situation(plan=True))
    mission.advance(103.0 + 3.0 * limit_s, situation(plan=True))
    assert any('simulated time stands still' in text for text in mission.faults)


def test_the_first_plan_leaves_battery_for_the_search(small: Callable[..., Path], tmp_path: Path):
    """As much as the rounds can take at most; agents may use it, and have the estimator."""
    search = {'radiation.search.extra_rounds': 2, 'radiation.search.viewpoints_a_round': 4}
    plain, found = (read_scenario(small({**AGENTS, **more})) for more in ({}, search))
    vehicle = found.vehicles[0]
    kept_s = search_reserve_s(found, vehicle)
    assert search_reserve_s(plain, vehicle) == 0.0
    assert 0.0 < kept_s < MOST_OF_BATTERY * vehicle.usable_endurance_s
    goal = plan_goal(found)
    assert goal.vehicles[0].endurance_s == pytest.approx(vehicle.usable_endurance_s - kept_s)
    assert plan_goal(plain).vehicles[0].endurance_s == vehicle.usable_endurance_s
    run = RunDirectory(tmp_path)
    parameters = agent_parameters(found, run)
    search_options = values_of(parameters['search_file'], SearchOptions, 'search')
    assert (search_options.extra_rounds, search_options.viewpoints_a_round) == (2, 4)
    batteries = values_of(parameters['batteries_file'], Batteries, 'batteries')
    assert batteries.vehicles[0].usable_s == vehicle.usable_endurance_s
    assert 'search_file' not in agent_parameters(plain, run)


def test_a_search_that_does_not_fit_keeps_half_of_the_battery(small: Callable[..., Path]):
    """The survey goes first; the agents fly what is left of the rounds."""
    search = {'radiation.search.extra_rounds': 20, 'radiation.search.viewpoints_a_round': 100}
    found = read_scenario(small({**AGENTS, **search}))
    usable_s = found.vehicles[0].usable_endurance_s
    assert planned_endurance_s(found, found.vehicles[0]) == MOST_OF_BATTERY * usable_s


def test_without_agents_losses_are_handled_here():
    """Simulated time does not wait for them, and the next loss is replaced."""
    mission = airborne()
    mission.gave_up('agents', 'ended with exit code 1')
    orders = mission.advance(102.0, situation())
    assert Order(kind=OrderKind.DISMISS, vehicle='agents') in orders
    mission.advance(103.0, situation(lost='rav1'))
    assert mission.phase is Phase.PLANNING
    assert mission.faults == []


def test_resumed_mission_plans_nothing_and_gives_no_route():
    """It lets time run and watches; what is missing when the agents are done is a fault."""
    mission = Mission(CREW, Deadlines(), has_agents=True, first=Phase.FLYING)
    orders = mission.advance(100.0, situation())
    assert orders == [Order(kind=OrderKind.RUN_CLOCK)]
    assert mission.phase is Phase.FLYING
    mission.advance(101.0, situation(done=True, stored=6))
    mission.advance(105.0, situation(done=True, stored=6))
    assert mission.phase is Phase.COLLECTING
    mission.advance(105.1, situation(done=True, stored=6))
    assert mission.phase is Phase.MAPPING
    assert mission.faults == []


@pytest.mark.parametrize(('stored', 'faults'), [(6, []), (5, ['only 5 of 6 photographs are'])])
def test_resumed_after_the_flight_only_map_and_products_are_made(stored, faults):
    """What was not photographed stays a fault."""
    mission = Mission(CREW, Deadlines(), has_agents=True, first=Phase.MAPPING)
    mission.advance(100.0, situation(stored=stored))
    assert mission.phase is Phase.MAPPING
    assert [text[: len(faults[0])] for text in mission.faults] == faults
    orders = mission.advance(100.1, situation(stored=stored))
    assert orders == [Order(kind=OrderKind.SAVE_MOSAIC)]


@pytest.mark.parametrize(
    ('changes', 'text'),
    [
        ({'survey.separation.by': 'layers'}, "by = 'layers': must be reserved"),
        ({'survey.separation.distance_m': 0}, 'distance_m = 0: must be positive'),
        ({'replan': 'never'}, "replan = 'never': must be on_loss"),
        (
            {'air.search.extra_rounds': 1, 'air.gas_sensors': ['pid_10_6_ev']},
            'air.search.extra_rounds = 1: must be 0 with fleet.agents',
        ),
    ],
)
def test_scenarios_that_agents_cannot_fly_are_refused(
    small: Callable[..., Path], changes: dict[str, object], text: str
):
    """With the key and its limit."""
    with pytest.raises(ScenarioError, match=text):
        read_scenario(small({**AGENTS, **changes}))


def test_time_waits_for_the_agents(small: Callable[..., Path]):
    """And does not pause for news, which they answer themselves."""
    parameters = world_parameters(read_scenario(small(AGENTS)))
    assert 'agents' in parameters['participants']
    assert not parameters['pause_on_news']
    assert 'agents' not in world_parameters(read_scenario(small()))['participants']
