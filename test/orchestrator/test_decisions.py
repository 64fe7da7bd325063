# SPDX-License-Identifier: Apache-2.0
"""Each decision of a mission is told once."""

from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Crew
from rocsafe_orchestrator.watches.decisions import ERROR, WARN, Decisions


def mission() -> Mission:
    """Return a mission of one vehicle."""
    crew = Crew(vehicle_processes={'rav1': 'rav1'}, processes=frozenset({'rav1', 'planner'}))
    return Mission(crew, Deadlines())


def test_what_is_told_is_not_told_again() -> None:
    """A phase, a fault and a loss are news once."""
    flown, decisions = mission(), Decisions()
    assert [d.text for d in decisions.of_mission(flown)] == ['starting']
    assert decisions.of_mission(flown) == []
    flown.cancel('interrupted')
    told = {d.kind: d for d in decisions.of_mission(flown)}
    assert (told['fault'].text, told['fault'].severity) == ('interrupted', ERROR)
    assert told['phase'].text == 'reporting'
    assert decisions.of_mission(flown) == []


def test_repeated_order_is_one_decision() -> None:
    """An order that is repeated until it is accepted was decided once a phase."""
    decisions, hold = Decisions(), Order(kind=OrderKind.HOLD, vehicle='rav1')
    (told,) = decisions.of_order(hold)
    assert (told.kind, told.text, told.vehicles) == ('order', 'hold', ('rav1',))
    assert decisions.of_order(hold) == []
    decisions.of_mission(mission())
    assert decisions.of_order(hold)


def test_loss_names_the_vehicle_and_why() -> None:
    """A lost vehicle is a warning: the others go on."""
    flown, decisions = mission(), Decisions()
    decisions.of_mission(flown)
    flown.fleet.lost['rav1'] = 'battery failed'
    (told,) = decisions.of_mission(flown)
    assert (told.vehicles, told.reason, told.severity) == (('rav1',), 'battery failed', WARN)
