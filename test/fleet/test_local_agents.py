# SPDX-License-Identifier: Apache-2.0
"""Agents of one process, how they begin, and what messages of vehicles mean to them."""

import json
import math
from pathlib import Path

import pytest

from rocsafe_fleet.conversions import (
    inability,
    numbers_of,
    place_of_state,
    route_of,
    state_of,
    visited_of,
)
from rocsafe_fleet.fleet_start import FleetStart, fleet_start
from rocsafe_fleet.options import AgentOptions
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import Control, GeoPoint, VehicleState
from rocsafe_planner.plan.plan_json import plan_document

from . import surveys


@pytest.fixture
def begin(tmp_path: Path):
    """Give a function that starts the agents of some vehicles; all starts share a folder."""
    path = tmp_path / 'plan.json'
    plan = surveys.survey()
    path.write_text(json.dumps(plan_document(plan)))

    def start(*vehicles: str, plan_id: str = plan.plan_id, folder: str = 'state') -> FleetStart:
        options = AgentOptions(
            vehicles=vehicles, plan_file=str(path), state_directory=str(tmp_path / folder)
        )
        return fleet_start(options, plan_id, 'token', 0.0)

    return start


@pytest.mark.slow
def test_agents_of_two_processes_agree(begin):
    """They hear those of their own process at once, the others by the link."""
    one, two = begin('rav0', 'rav1', folder='a'), begin('rav2', 'rav3', folder='b')
    place = place_of_state(state(), 1000.0)
    for tick in range(80):
        now_s = 0.1 * tick
        for fleet, other in ((one, two), (two, one)):
            for agent in fleet.local.agents.values():
                agent.move(place)
            for data in fleet.local.advance(now_s):
                other.local.receive(data, now_s)
                fleet.local.receive(data, now_s)
        if tick == 30:
            two.agent('rav3').disable('battery')
        for fleet in (one, two):
            if (wanted := fleet.local.wanted) is not None:
                fleet.local.planned(wanted, fleet.plan(wanted, lambda _: True))
    agents = [*one.local.agents.values(), *two.local.agents.values()]
    assert {agent.epoch[:2] for agent in agents} == {(1, 0)}
    assert len({agent.plan.digest for agent in agents}) == 1
    assert agents[0].proposal.names == {0, 1, 2}
    told = state_of(agents[0], one.names, 10, is_done=False, is_planning=True)
    assert (told.coordinator, told.members) == ('rav0', ['rav0', 'rav1', 'rav2'])
    assert told.unable == ['rav3']
    assert told.is_planning
    assert told.search_round == 0


def test_agents_that_start_again_know_what_they_knew(begin):
    """Photographs, routes and the number of their start are kept on disk."""
    fleet = begin('rav0', 'rav1')
    fleet.agent('rav0').visit([3, 5])
    fleet.save({'rav0': {'plan': (3, 5, 7)}})
    again = begin('rav0', 'rav1')
    assert again.load() == {'rav0': {'plan': [3, 5, 7]}}
    assert again.agent('rav0').visited == {3, 5}
    assert again.agent('rav1').visited == {3, 5}
    assert again.agent('rav0').ledger.writer > fleet.agent('rav0').ledger.writer


@pytest.mark.parametrize('name', ['starts.txt', 'ledger.bin', 'routes.json'])
def test_damaged_files_do_not_keep_agents_from_starting(begin, tmp_path, name):
    """What cannot be read is left out; the other agents know it."""
    begin('rav0').save({'rav0': {'plan': (3,)}})
    (tmp_path / 'state' / name).write_bytes(b'\xff')
    again = begin('rav0')
    assert isinstance(again.load(), dict)
    assert again.agent('rav0').ledger.writer[1] > 1 << 16


def test_wrong_plans_and_vehicles_are_refused(begin):
    """The text names them."""
    with pytest.raises(ValueError, match='not other'):
        begin('rav0', plan_id='other')
    with pytest.raises(ValueError, match="'rav9': must be of rav0, rav1"):
        begin('rav9')


def state(**values: object) -> VehicleState:
    """Return the state of a vehicle in the air."""
    return VehicleState(
        **{
            'vehicle': 'rav0',
            'state': VehicleState.FLYING,
            'battery_fraction': 0.75,
            'position': GeoPoint(latitude=53.28, longitude=-9.06, altitude=42.0),
            **values,
        }
    )


def test_what_a_state_tells():
    """Place, used battery, and photographs that were handed over."""
    place = place_of_state(state(), 1000.0)
    assert place is not None
    assert (place.used_s, place.is_aloft) == (250.0, True)
    nowhere = GeoPoint(latitude=math.nan, longitude=math.nan)
    assert place_of_state(state(position=nowhere), 1000.0) is None
    assert visited_of(state(viewpoints_visited=3, shots_pending=1), (7, 8, 9, 4)) == (7, 8)


@pytest.mark.parametrize(
    ('values', 'is_real', 'text'),
    [
        ({}, False, ''),
        ({'taken_by': 'pilot'}, True, 'its pilot has it'),
        ({'ending': FlyRoute.Result.BATTERY_LOW, 'text': 'low'}, False, 'low'),
        ({'ending': FlyRoute.Result.ABORTED}, False, 'aborted its flight'),
        ({'state': VehicleState.CRASHED}, False, 'it is lost'),
        ({'state': VehicleState.LANDED}, True, 'it has landed'),
        ({'state': VehicleState.LANDED}, False, ''),
    ],
)
def test_who_takes_no_more_work(values, is_real, text):
    """Whoever is not at the mission's disposal, and why."""
    assert inability(state(**values), None, 'one', is_real) == text


def test_who_is_led_by_somebody_else_takes_no_work():
    """The orchestrator of the same mission is not somebody else."""
    for mission, text in (('one', ''), ('', 'anna leads it')):
        control = Control(holder='anna', mission=mission, lease='a/1')
        assert inability(state(), control, 'one', is_real=False) == text


def test_a_route_goes_without_what_is_photographed_already():
    """The first viewpoints only: the others keep the legs that the checker has seen."""
    plan = surveys.survey()
    numbers = tuple(view.id for view in plan.routes[0].viewpoints)
    route = route_of(plan, 'rav0', frozenset(numbers[:2]) | {numbers[4]})
    assert route is not None
    assert numbers_of(route) == numbers[2:]
    assert [int(view.id) for view in route.flights[0].viewpoints] == list(numbers[2:])
    assert route_of(plan, 'rav0', frozenset(numbers)) is None
