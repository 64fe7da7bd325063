# SPDX-License-Identifier: Apache-2.0
"""Goals of actions: an order that is sent twice, for it was accepted late, has one answer."""

from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient, ActionServer
from rclpy.node import Node
from rclpy.task import Future

from rocsafe_interfaces.action import PlanSurvey
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Crew, Situation
from rocsafe_orchestrator.requests import goal_requests_node
from rocsafe_orchestrator.requests.goal_requests_node import GoalRequests

DEADLINE_S = 30.0

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
        handle.result.set_result(SimpleNamespace(status=GoalStatus.STATUS_SUCCEEDED))
    assert answers == ['first']


def test_a_result_that_is_lost_is_asked_for_again(ros: Any, monkeypatch: Any) -> None:
    """It has one answer, though the server sends it once for each time that it is asked."""
    monkeypatch.setattr(goal_requests_node, 'ASK_AGAIN_S', 0.0)
    nodes = Node('planner', context=ros.context), Node('asker', context=ros.context)
    planned, lost, answers = Future(), [], []

    async def plan(goal: Any) -> PlanSurvey.Result:
        await planned
        goal.succeed()
        return PlanSurvey.Result(error_msg='the result')

    server = ActionServer(nodes[0], PlanSurvey, 'plan', execute_callback=plan)
    send = server._send_result_response

    def lose_the_first(header: Any, future: Any) -> None:
        if lost:
            send(header, future)
        lost.append(header)

    monkeypatch.setattr(server, '_send_result_response', lose_the_first)
    client = ActionClient(nodes[1], PlanSurvey, 'plan')
    for node in nodes:
        ros.executor.add_node(node)
    ros.spin_until(client.server_is_ready, DEADLINE_S)
    requests, mission = GoalRequests('planner'), Mission(CREW, Deadlines())
    requests.begin(mission)
    (order,) = mission.advance(0.0, READY) or mission.advance(0.0, READY)
    requests._send_goal(client, PlanSurvey.Goal(), order, lambda *given: answers.append(given))
    ros.spin_until(lambda: bool(requests._open), DEADLINE_S)
    planned.set_result(None)
    ros.spin_until(lambda: bool(lost), DEADLINE_S)
    assert not answers
    requests.ask_again()
    requests.ask_again()
    ros.spin_until(lambda: len(lost) == 3 and bool(answers), DEADLINE_S)
    ((answered, future),) = answers
    assert answered == order
    assert future.result().result.error_msg == 'the result'
    client.destroy()
    server.destroy()
    for node in nodes:
        ros.executor.remove_node(node)
        node.destroy_node()


def test_a_server_that_was_started_again_gives_no_result() -> None:
    """It does not know the goal, which looks like an empty result."""
    mission, requests, client = Mission(CREW, Deadlines()), GoalRequests('planner'), Client()
    requests.begin(mission)
    (order,) = mission.advance(0.0, READY) or mission.advance(0.0, READY)
    answers: list[str] = []
    requests._send_goal(client, None, order, partial(_note, answers, 'first'))
    handle = Handle()
    client.sent[0].set_result(handle)
    handle.result.set_result(SimpleNamespace(status=GoalStatus.STATUS_UNKNOWN))
    assert not answers


def _note(answers: list[str], name: str, _order: Order, _future: Future) -> None:
    answers.append(name)
