# SPDX-License-Identifier: Apache-2.0
"""Requests to the nodes that fly a mission, and their answers."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from rocsafe_interfaces.action import FlyRoute, PlanSurvey
from rocsafe_interfaces.msg import GeoPoint, Route, StepDone, SurveyPlan
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_orchestrator import conversions
from rocsafe_orchestrator.leases_node import Leases
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.request import Order, OrderKind
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.processes.process_table import Endpoint
from rocsafe_ros import topics
from rocsafe_scenario.scenario import Scenario


class Requests:
    """Clients of the planner, of every vehicle, of the world, the map maker and the localizer.

    Actions: ``plan_survey``, ``<vehicle>/fly_route``. Services: ``world/run``, ``mosaic/save``,
    ``hazard/suggest_viewpoints``.

    Parameters
    ----------
    node
        Node that owns the clients.
    monitor
        Receives the number of photographs of the plan.
    mission_id
        Name of the mission, for the leases of the vehicles.
    """

    def __init__(self, node: Node, scenario: Scenario, monitor: Monitor, mission_id: str) -> None:
        self._scenario = scenario
        self._monitor = monitor
        self._mission: Mission | None = None
        self._plans: dict[str, SurveyPlan] = {}
        self._plan: SurveyPlan | None = None
        self._viewpoints: list[GeoPoint] = []
        self._planner = ActionClient(node, PlanSurvey, topics.PLAN_SURVEY.name)
        self._vehicles = {
            name: ActionClient(node, FlyRoute, topics.name_of(topics.FLY_ROUTE, name))
            for name in scenario.vehicle_names
        }
        self._leases = Leases(node, scenario.vehicle_names, mission_id, self._remark)
        self._services: dict[str, Client] = {
            spec.name: node.create_client(spec.call_type, spec.name)
            for spec in (topics.WORLD_RUN, topics.SAVE_MOSAIC, topics.SUGGEST_VIEWPOINTS)
        }
        self._holds: dict[str, Client] = {
            name: node.create_client(topics.HOLD.call_type, topics.name_of(topics.HOLD, name))
            for name in (scenario.vehicle_names if scenario.replan == 'on_loss' else ())
        }
        self._steps = topics.create_publisher(node, topics.STEP_DONE)
        self._visited: list[int] = []
        self._photographed = 0
        self._send: dict[OrderKind, Callable[[Order], None]] = {
            OrderKind.PLAN: self._send_plan,
            OrderKind.FLY: self._send_fly,
            OrderKind.ADVISE: self._send_advise,
            OrderKind.HOLD: self._send_hold,
            OrderKind.DISMISS: self._dismiss,
            OrderKind.PAUSE_CLOCK: self._pause,
            OrderKind.RUN_CLOCK: partial(self._call, topics.WORLD_RUN, SetBool.Request(data=True)),
            OrderKind.SAVE_MOSAIC: partial(self._call, topics.SAVE_MOSAIC, Trigger.Request()),
        }

    def begin(self, mission: Mission) -> None:
        """Report answers to `mission` from now on."""
        self._mission = mission

    def close(self) -> None:
        """Destroy the clients of actions, which keep their node in the graph."""
        for client in (self._planner, *self._vehicles.values()):
            client.destroy()

    def send(self, order: Order) -> None:
        """Send `order` to the node that carries it out."""
        self._send[order.kind](order)

    def is_ready(self, endpoint: Endpoint) -> bool:
        """Return whether the server of a service or an action can be reached."""
        if endpoint.kind == 'service':
            return bool(self._services[endpoint.name].service_is_ready())
        client = self._vehicles.get(endpoint.vehicle, self._planner)
        return bool(client.server_is_ready())

    def _send_plan(self, order: Order) -> None:
        goal = conversions.plan_goal(self._scenario)
        if self._mission is not None and self._mission.is_gathering and self._plan is not None:
            goal = conversions.rest_goal(
                self._scenario, self._plan, self._monitor, self._mission.losses
            )
            self._visited = list(goal.visited)
            if len(self._visited) == conversions.viewpoint_count(self._plan):
                self._mission.nothing_left()
                return
        elif self._viewpoints:
            goal = conversions.further_goal(goal, self._viewpoints, list(self._plans.values()))
        self._send_goal(self._planner, goal, order, self._on_plan)

    def _send_fly(self, order: Order) -> None:
        if self._plan is None:
            return
        routes: dict[str, Route] = {route.vehicle: route for route in self._plan.routes}
        goal = FlyRoute.Goal(
            route=routes[order.vehicle],
            plan_id=self._plan.plan_id,
            replace=bool(self._photographed or self._visited),
        )
        on_flight = partial(self._on_flight, self._plan.plan_id)

        def send(lease: str) -> None:
            goal.lease = lease
            self._send_goal(self._vehicles[order.vehicle], goal, order, on_flight)

        self._leases.carry(order.vehicle, send, partial(self._on_refusal, order))

    def _on_refusal(self, order: Order, text: str) -> None:
        if self._mission is not None:
            self._mission.refused(order, text)

    def _remark(self, text: str) -> None:
        if self._mission is not None:
            self._mission.remarks.append(text)

    def _send_hold(self, order: Order) -> None:
        client = self._holds[order.vehicle]
        answer = client.call_async(Trigger.Request())
        answer.add_done_callback(partial(self._on_answer, topics.HOLD, order))

    def _dismiss(self, order: Order) -> None:
        self._steps.publish(StepDone(participant=order.vehicle, has_left=True))
        if self._mission is not None:
            self._mission.answered(order)

    def _pause(self, order: Order) -> None:
        """Pause simulated time, unless a real vehicle takes part."""
        if not self._scenario.linked:
            self._call(topics.WORLD_RUN, SetBool.Request(data=False), order)
        elif self._mission is not None:
            self._mission.answered(order)

    def _send_advise(self, order: Order) -> None:
        request = SuggestViewpoints.Request(
            count=self._scenario.radiation.search.viewpoints_a_round
        )
        client = self._services[topics.SUGGEST_VIEWPOINTS.name]
        client.call_async(request).add_done_callback(partial(self._on_advice, order))

    def _on_advice(self, _order: Order, future: Any) -> None:
        answer = future.result()
        # The localizer is still working: the request is repeated.
        if self._mission is None or answer is None or answer.status == answer.NOT_YET:
            return
        self._viewpoints = list(answer.viewpoints)
        self._mission.advised(len(self._viewpoints), answer.reason)

    def _send_goal(
        self, client: ActionClient, goal: Any, order: Order, on_result: Callable[..., None]
    ) -> None:
        sent = client.send_goal_async(goal)
        sent.add_done_callback(partial(self._on_goal, order, on_result))

    def _on_goal(self, order: Order, on_result: Callable[..., None], future: Any) -> None:
        handle = future.result()
        if self._mission is None or handle is None:
            return
        if not handle.accepted:
            self._mission.refused(order, f'{order.vehicle or "planner"}: request was not accepted')
            return
        self._mission.accepted(order)
        handle.get_result_async().add_done_callback(partial(on_result, order))

    def _on_plan(self, order: Order, future: Any) -> None:
        result = future.result().result
        if self._mission is None:
            return
        if result.error_code != result.NONE:
            self._mission.refused(order, f'planner: {result.error_msg}')
            return
        if unseen := conversions.unseen_viewpoint(self._scenario, result.plan):
            self._mission.refused(order, unseen)
            return
        visited, self._visited = self._visited, []
        if self._mission.is_gathering and self._plan is not None:
            self._photographed += len(visited)
            del self._plans[self._plan.plan_id]
        self._plan = self._plans[result.plan.plan_id] = result.plan
        # a vehicle in the air without viewpoints left flies home
        routed = [r for r in result.plan.routes if r.flights or r.viewpoints]
        expected = sum(map(conversions.viewpoint_count, self._plans.values()))
        self._monitor.images_expected = expected + self._photographed
        viewpoints = conversions.viewpoint_count(result.plan)
        self._monitor.begin_plan(result.plan.plan_id, viewpoints)
        self._mission.planned([route.vehicle for route in routed], len(visited))

    def _on_flight(self, plan_id: str, order: Order, future: Any) -> None:
        result = future.result().result
        # A repeated request is answered twice; the second answer may come in the next round.
        is_current = self._plan is not None and self._plan.plan_id == plan_id
        if self._mission is not None and is_current:
            fault = conversions.fault_of_flight(result)
            self._mission.flown(order.vehicle, result.shots_taken, fault)

    def _call(self, spec: topics.CallSpec, request: Any, order: Order) -> None:
        client = self._services[spec.name]
        client.call_async(request).add_done_callback(partial(self._on_answer, spec, order))

    def _on_answer(self, spec: topics.CallSpec, order: Order, future: Any) -> None:
        answer = future.result()
        if self._mission is None or answer is None:
            return
        if answer.success:
            self._mission.answered(order)
        else:
            self._mission.refused(order, f'{spec.name}: {answer.message}')
