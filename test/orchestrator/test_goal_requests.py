# SPDX-License-Identifier: Apache-2.0
"""Goals of actions: an order that is sent twice, for it was accepted late, has one answer."""

from functools import partial
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.task import Future

from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Crew, Situation
from rocsafe_orchestrator.requests.goal_requests_node import GoalRequests

CREW = Crew(vehicle_processes={'rav1': 'rav1'}, processes=frozenset({'planner', 'rav1'}))
READY = Situation(ready=CREW.processes)


class Handle:
    """Stands for a goal that the server has accepted; its result comes when the test says."""

    accepted = True

    def __init__(self) -> None:
        self.result = Future()

    def get_result_async(self) -> Future:
        """Return the future of the result."""
        return self.result


class Client:
    """Stands for an action client: keeps the futures of the acceptances."""

    def __init__(self) -> None:
        self.sent: list[Future] = []

    def send_goal_async(self, _goal: Any) -> Future:
        """Return the future of the acceptance."""
        self.sent.append(Future())
        return self.sent[-1]


def test_of_two_accepted_goals_one_answers() -> None:
    """The second is the repetition: its result would be taken for a second plan."""
    mission, requests, client = Mission(CREW, Deadlines()), GoalRequests('planner'), Client()
    requests.begin(mission)
    (order,) = mission.advance(0.0, READY) or mission.advance(0.0, READY)
    assert order == Order(kind=OrderKind.PLAN)
    answers: list[str] = []
    for name in ('first', 'second'):
        requests._send_goal(client, None, order, partial(_note, answers, name))
    handles = [Handle(), Handle()]
    for sent, handle in zip(client.sent, handles, strict=True):
        sent.set_result(handle)
    for handle in handles:
        handle.result.set_result('plan')
    assert answers == ['first']


def _note(answers: list[str], name: str, _order: Order, _future: Future) -> None:
    answers.append(name)
