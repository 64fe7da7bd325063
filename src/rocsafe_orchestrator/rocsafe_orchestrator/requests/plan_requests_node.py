# SPDX-License-Identifier: Apache-2.0
"""Requests to the planner, and the plans that a mission has flown."""

from pathlib import Path
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.node import Node

from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_interfaces.action import PlanSurvey
from rocsafe_interfaces.msg import Route, SurveyPlan
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.parameters import goal_conversions
from rocsafe_orchestrator.requests.advice_requests_node import AdviceRequests
from rocsafe_orchestrator.requests.goal_requests_node import GoalRequests
from rocsafe_planner.conversions import message_of_plan
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_ros.interfaces import calls
from rocsafe_ros.plan_digest import plan_digest
from rocsafe_scenario.scenario import Scenario

# A server whose callback fails answers with an empty result, which looks like success.
BROKEN_OFF = 'broke off with an error, see its log'


class PlanRequests(GoalRequests):
    """Client of the planner: action ``plan_survey``.

    Parameters
    ----------
    node
        Node that owns the client.
    monitor
        Receives the number of photographs of the plan.
    advice
        Knows where further rounds lead.

    Attributes
    ----------
    plan
        The newest plan; None: there is none yet.
    replaces
        Whether it replaces a plan that the vehicles fly.
    routes
        All routes, by the identifier of their plan and the vehicle.
    client
        Client of the action.
    unconfirmed
        Hash of a plan by which real vehicles would take off, until it is confirmed; empty: none.
    """

    def __init__(
        self, node: Node, scenario: Scenario, monitor: Monitor, advice: AdviceRequests
    ) -> None:
        super().__init__('planner')
        self.plan: SurveyPlan | None = None
        self.replaces = False
        self.routes: dict[tuple[str, str], Route] = {}
        self.client = ActionClient(node, PlanSurvey, calls.PLAN_SURVEY.name)
        self.unconfirmed = ''
        self._scenario, self._monitor, self._advice = scenario, monitor, advice
        self._plans: dict[str, SurveyPlan] = {}
        self._visited: list[int] = []
        self._routed: list[str] = []
        self._photographed = 0

    def resume(self, path: Path) -> None:
        """Take the plan that the mission flies already from its file."""
        terrain = self._scenario.survey.terrain_file
        plan = message_of_plan(read_plan(path, read_terrain(terrain) if terrain else None))
        self.plan = self._plans[plan.plan_id] = plan
        self.replaces = True
        self.routes.update(((plan.plan_id, route.vehicle), route) for route in plan.routes)
        viewpoints = goal_conversions.viewpoint_count(plan)
        self._expect_images(viewpoints)
        self._monitor.begin_plan(plan.plan_id, viewpoints)

    def send(self, order: Order) -> None:
        """Ask for a plan of the survey, of its rest, or of a further round."""
        goal = goal_conversions.plan_goal(self._scenario)
        if (
            self._mission is not None
            and self._mission.fleet.is_gathering
            and self.plan is not None
        ):
            goal = goal_conversions.rest_goal(
                self._scenario,
                (self.plan, self.routes),
                self._monitor,
                self._mission.fleet.others,
                self._mission.fleet.unheard,
            )
            self._visited = list(goal.visited)
            if len(self._visited) == goal_conversions.viewpoint_count(self.plan):
                self._mission.nothing_left()
                return
        elif self._advice.viewpoints:
            goal = goal_conversions.further_goal(
                goal, self._advice.viewpoints, list(self._plans.values())
            )
        self._send_goal(self.client, goal, order, self._on_plan)

    def _on_plan(self, order: Order, future: Any) -> None:
        answer = future.result()
        result = answer.result
        if self._mission is None:
            return
        if result.error_code == result.NONE and answer.status != GoalStatus.STATUS_SUCCEEDED:
            self._refuse(order, f'planner: {BROKEN_OFF}')
            return
        if result.error_code != result.NONE:
            self._refuse(order, f'planner: {result.error_msg}')
            return
        if unseen := goal_conversions.unseen_viewpoint(self._scenario, result.plan):
            self._refuse(order, unseen)
            return
        visited, self._visited = self._visited, []
        if self._mission.fleet.is_gathering and self.plan is not None:
            self._photographed += len(visited)
            self.replaces = True
            del self._plans[self.plan.plan_id]
        self.plan = self._plans[result.plan.plan_id] = result.plan
        self.routes.update(((result.plan.plan_id, r.vehicle), r) for r in result.plan.routes)
        if near := result.plan.near_unheard:
            self._mission.remarks.append(
                f'{", ".join(near)}: climbs, descends or flies near where a vehicle may be that '
                'is in no plan; no layer avoids it'
            )
        # a vehicle in the air without viewpoints left flies home
        routed = [r for r in result.plan.routes if r.flights or r.viewpoints]
        expected = sum(map(goal_conversions.viewpoint_count, self._plans.values()))
        self._expect_images(expected + self._photographed)
        viewpoints = goal_conversions.viewpoint_count(result.plan)
        self._monitor.begin_plan(result.plan.plan_id, viewpoints)
        self._routed = [route.vehicle for route in routed]
        real = {vehicle.name for vehicle in self._scenario.linked} & set(self._routed)
        # The rest of a plan that was confirmed needs no confirmation of its own.
        if real and not self._mission.fleet.is_gathering:
            self.unconfirmed = plan_digest(result.plan.plan_id, result.plan.routes)
        else:
            # Of these the image store owes a photograph each.
            taken = len(visited) if self._scenario.has_cameras else 0
            self._mission.planned(self._routed, taken)

    def _expect_images(self, count: int) -> None:
        self._monitor.images_expected = count if self._scenario.has_cameras else 0

    def confirm(self) -> None:
        """Fly the plan that waits for a confirmation."""
        self.unconfirmed = ''
        if self._mission is not None:
            self._mission.planned(self._routed)

    def reject(self, text: str) -> None:
        """Refuse the plan that waits for a confirmation, with the reason."""
        self.unconfirmed = ''
        self._refuse(Order(kind=OrderKind.PLAN), text)
