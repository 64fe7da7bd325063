# SPDX-License-Identifier: Apache-2.0
"""Requests to the nodes that fly a mission, and their answers."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_interfaces.action import FlyRoute, PlanSurvey
from rocsafe_interfaces.msg import Route, StepDone, SurveyPlan
from rocsafe_interfaces.srv import FleetCommand
from rocsafe_orchestrator import conversions
from rocsafe_orchestrator.advice_requests_node import AdviceRequests
from rocsafe_orchestrator.drive_requests_node import DriveRequests
from rocsafe_orchestrator.mission.confirmation import Confirmation
from rocsafe_orchestrator.mission.drive_watch import Reading
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.request import Order, OrderKind
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.parameters import goal_conversions
from rocsafe_orchestrator.parameters.node_parameters import AGENTS, FLEET
from rocsafe_orchestrator.processes.process_table import Endpoint
from rocsafe_orchestrator.watches.operator_watch import Verb
from rocsafe_orchestrator.watches.retreat import retreat
from rocsafe_planner.conversions import message_of_plan
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_ros import topics
from rocsafe_ros.lease_holder_node import Leases
from rocsafe_ros.plan_digest import plan_digest, route_digest
from rocsafe_scenario.scenario import Scenario

SERVICES = (
    topics.WORLD_RUN,
    topics.SAVE_MOSAIC,
    topics.SUGGEST_VIEWPOINTS,
    topics.SUGGEST_GAS_VIEWPOINTS,
    topics.FLEET_HOLD,
    topics.FLEET_RETURN_HOME,
)
_VERBS = {OrderKind.HOLD: topics.HOLD, OrderKind.RETURN: topics.RETURN_HOME}
# A server whose callback fails answers with an empty result, which looks like success.
BROKEN_OFF = 'broke off with an error, see its log'


class Requests:
    """Clients of the planner, the vehicles, the world, the map maker, localizer and estimator.

    Actions: ``plan_survey``, ``<vehicle>/fly_route``. Services: ``<vehicle>/hold``,
    ``<vehicle>/return_home``, ``world/run``, ``mosaic/save``.

    Parameters
    ----------
    node
        Node that owns the clients.
    monitor
        Receives the number of photographs of the plan.
    mission_id
        Name of the mission, for the leases of the vehicles.

    Attributes
    ----------
    unconfirmed
        By what real vehicles would move, until it is confirmed or refused; None: nothing.
    """

    def __init__(self, node: Node, scenario: Scenario, monitor: Monitor, mission_id: str) -> None:
        self._scenario = scenario
        self._monitor = monitor
        self._mission: Mission | None = None
        self._plans: dict[str, SurveyPlan] = {}
        self._plan: SurveyPlan | None = None
        self._routes: dict[tuple[str, str], Route] = {}
        self._planner = ActionClient(node, PlanSurvey, topics.PLAN_SURVEY.name)
        self._vehicles = {
            name: ActionClient(node, FlyRoute, topics.name_of(topics.FLY_ROUTE, name))
            for name in scenario.vehicle_names
        }
        self._leases = Leases(
            node, scenario.all_names, mission_id, self._remark, role='orchestrator'
        )
        self._services: dict[str, Client] = {
            spec.name: node.create_client(spec.call_type, spec.name) for spec in SERVICES
        }
        self._verbs: dict[tuple[OrderKind, str], Client] = {
            (kind, name): node.create_client(spec.call_type, topics.name_of(spec, name))
            for kind, spec in _VERBS.items()
            for name in scenario.all_names
        }
        self._advice = AdviceRequests(self._services, scenario)
        self.unconfirmed: Confirmation | None = None
        self._drives = self._drives_of(node) if scenario.driver_name else None
        self._steps = topics.create_publisher(node, topics.STEP_DONE)
        self._real = {vehicle.name for vehicle in scenario.linked}
        self._visited: list[int] = []
        self._routed: list[str] = []
        self._replaces = False
        self._photographed = 0
        self._send: dict[OrderKind, Callable[[Order], None]] = {
            OrderKind.PLAN: self._send_plan,
            OrderKind.FLY: self._send_fly,
            OrderKind.ADVISE: self._advice.send,
            OrderKind.HOLD: self._send_verb,
            OrderKind.RETURN: self._send_verb,
            OrderKind.RETREAT: self._send_retreat,
            OrderKind.DISMISS: self._dismiss,
            OrderKind.PAUSE_CLOCK: self._pause,
            OrderKind.RUN_CLOCK: partial(self._call, topics.WORLD_RUN, SetBool.Request(data=True)),
            OrderKind.SAVE_MOSAIC: partial(self._call, topics.SAVE_MOSAIC, Trigger.Request()),
        }

        if self._drives is not None:
            self._send |= {
                OrderKind.ASSESS: self._drives.send_assess,
                OrderKind.PLAN_DRIVE: self._drives.send_plan,
                OrderKind.DRIVE: self._drives.send_drive,
            }

    def _drives_of(self, node: Node) -> DriveRequests:
        asked = [topics.SUGGEST_VIEWPOINTS]
        if self._scenario.air.gas_sensors:
            asked.append(topics.SUGGEST_GAS_VIEWPOINTS)
        assessors = [self._services[spec.name] for spec in asked]
        home = Order(kind=OrderKind.RETURN, vehicle=self._scenario.driver_name)
        return DriveRequests(
            node, self._scenario, self._monitor, self._leases, assessors,
            partial(setattr, self, 'unconfirmed'), partial(self._send_verb, home),
        )  # fmt: skip

    def begin(self, mission: Mission) -> None:
        """Report answers to `mission` from now on."""
        self._mission = mission
        self._advice.begin(mission)
        if self._drives is not None:
            self._drives.begin(mission)

    def resume(self, path: Path) -> None:
        """Take the plan that the mission flies already from its file."""
        terrain = self._scenario.survey.terrain_file
        plan = message_of_plan(read_plan(path, read_terrain(terrain) if terrain else None))
        self._plan = self._plans[plan.plan_id] = plan
        self._replaces = True
        self._routes.update(((plan.plan_id, route.vehicle), route) for route in plan.routes)
        self._monitor.images_expected = goal_conversions.viewpoint_count(plan)
        self._monitor.begin_plan(plan.plan_id, self._monitor.images_expected)

    def on_sources(self) -> None:
        """Note that the sources which are known have changed."""
        if self._drives is not None:
            self._drives.on_sources()

    def on_reading(self, reading: Reading) -> None:
        """Note a reading of the ground vehicle."""
        if self._drives is not None:
            self._drives.on_reading(reading)

    def replan(self) -> str:
        """Have the rest of the mission planned anew; return why not, empty if it is."""
        if self._mission is None:
            return 'cannot plan anew: no mission has begun'
        return self._mission.replan(self._leases.lost)

    def close(self) -> None:
        """Destroy the clients of actions, which keep their node in the graph."""
        for client in (self._planner, *self._vehicles.values()):
            client.destroy()
        if self._drives is not None:
            self._drives.close()

    def send(self, order: Order) -> None:
        """Send `order` to the node that carries it out."""
        self._send[order.kind](order)

    def is_ready(self, endpoint: Endpoint) -> bool:
        """Return whether the server of a service or an action can be reached."""
        if endpoint.kind == 'service':
            return bool(self._services[endpoint.name].service_is_ready())
        if self._drives is not None and endpoint.spec is topics.PLAN_GROUND_ROUTE:
            return bool(self._drives.router.server_is_ready())
        if self._drives is not None and endpoint.spec is topics.DRIVE_ROUTE:
            return bool(self._drives.vehicle.server_is_ready())
        client = self._vehicles.get(endpoint.vehicle, self._planner)
        return bool(client.server_is_ready())

    def command_fleet(self, verb: Verb) -> None:
        """Command all vehicles, and report their refusals."""
        spec = topics.FLEET_HOLD if verb is Verb.HOLD else topics.FLEET_RETURN_HOME
        answer = self._services[spec.name].call_async(FleetCommand.Request())
        answer.add_done_callback(self._on_fleet)

    def _on_fleet(self, future: Any) -> None:
        for answer in future.result().answers:
            if answer.message:
                self._remark(answer.message)

    def _send_plan(self, order: Order) -> None:
        goal = goal_conversions.plan_goal(self._scenario)
        if (
            self._mission is not None
            and self._mission.fleet.is_gathering
            and self._plan is not None
        ):
            goal = goal_conversions.rest_goal(
                self._scenario,
                (self._plan, self._routes),
                self._monitor,
                self._mission.fleet.others,
                self._mission.fleet.unheard,
            )
            self._visited = list(goal.visited)
            if len(self._visited) == goal_conversions.viewpoint_count(self._plan):
                self._mission.nothing_left()
                return
        elif self._advice.viewpoints:
            goal = goal_conversions.further_goal(
                goal, self._advice.viewpoints, list(self._plans.values())
            )
        self._send_goal(self._planner, goal, order, self._on_plan)

    def _send_fly(self, order: Order) -> None:
        if self._plan is None:
            return
        route = self._routes[self._plan.plan_id, order.vehicle]
        if not route.viewpoints and order.vehicle in self._real and self._mission is not None:
            self._mission.sent_home(order.vehicle)
            return
        goal = FlyRoute.Goal(
            route=route,
            plan_id=self._plan.plan_id,
            replace=self._replaces,
        )
        self._send_flight(order, goal, partial(self._on_flight, self._plan.plan_id))

    def _send_flight(
        self, order: Order, goal: FlyRoute.Goal, on_result: Callable[..., None]
    ) -> None:
        def send(lease: str) -> None:
            goal.lease = lease
            goal.confirmation = route_digest(goal.plan_id, goal.route)
            self._send_goal(self._vehicles[order.vehicle], goal, order, on_result)

        self._leases.carry(order.vehicle, send, partial(self._on_refusal, order))

    def _on_refusal(self, order: Order, text: str) -> None:
        if self._mission is not None:
            self._mission.refused(order, text)

    def _remark(self, text: str) -> None:
        if self._mission is not None:
            self._mission.remarks.append(text)

    def _send_retreat(self, order: Order) -> None:
        """Call a vehicle home by the way of least dose; over terrain by its own way."""
        status = self._monitor.vehicle(order.vehicle)
        route = self._routes.get((status.plan_id, order.vehicle))
        if self._mission is None:
            return
        if route is None or route.follows_terrain or status.position is None:
            why = 'its height above the ground is not known on the way'
            self._mission.refused(order, f'{order.vehicle}: {why}')
            return
        danger, frame = conversions.danger_of(
            self._scenario, route, self._monitor, status.position
        )
        way = retreat(danger)
        self._mission.remarks.append(
            f'{order.vehicle}: returns by the way of least dose {way.basis}: {way.dose_usv:.3g} '
            f'uSv, {way.straight_usv:.3g} uSv straight'
        )
        goal = FlyRoute.Goal(
            route=conversions.retreat_route(route, way, status.position, frame),
            plan_id=f'{status.plan_id}-retreat',
            replace=True,
        )
        self._send_flight(order, goal, self._on_retreat)

    def _on_retreat(self, order: Order, future: Any) -> None:
        result = future.result().result
        if self._mission is not None and result.outcome == result.REJECTED:
            self._mission.refused(order, f'{order.vehicle}: {result.error_msg}')

    def _send_verb(self, order: Order) -> None:
        answer = self._verbs[order.kind, order.vehicle].call_async(Trigger.Request())
        answer.add_done_callback(partial(self._on_answer, _VERBS[order.kind], order))

    def _dismiss(self, order: Order) -> None:
        is_shared = self._scenario.simulation.processes == 'fleet' and order.vehicle != AGENTS
        participant = FLEET if is_shared else order.vehicle
        self._steps.publish(StepDone(participant=participant, has_left=True))
        if self._mission is not None:
            self._mission.answered(order)

    def _pause(self, order: Order) -> None:
        """Pause simulated time, unless a real vehicle takes part."""
        if not self._scenario.real_names:
            self._call(topics.WORLD_RUN, SetBool.Request(data=False), order)
        elif self._mission is not None:
            self._mission.answered(order)

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
        answer = future.result()
        result = answer.result
        if self._mission is None:
            return
        if result.error_code == result.NONE and answer.status != GoalStatus.STATUS_SUCCEEDED:
            self._mission.refused(order, f'planner: {BROKEN_OFF}')
            return
        if result.error_code != result.NONE:
            self._mission.refused(order, f'planner: {result.error_msg}')
            return
        if unseen := goal_conversions.unseen_viewpoint(self._scenario, result.plan):
            self._mission.refused(order, unseen)
            return
        visited, self._visited = self._visited, []
        if self._mission.fleet.is_gathering and self._plan is not None:
            self._photographed += len(visited)
            self._replaces = True
            del self._plans[self._plan.plan_id]
        self._plan = self._plans[result.plan.plan_id] = result.plan
        self._routes.update(((result.plan.plan_id, r.vehicle), r) for r in result.plan.routes)
        if near := result.plan.near_unheard:
            self._mission.remarks.append(
                f'{", ".join(near)}: climbs, descends or flies near where a vehicle may be that '
                'nobody hears; no layer avoids it'
            )
        # a vehicle in the air without viewpoints left flies home
        routed = [r for r in result.plan.routes if r.flights or r.viewpoints]
        expected = sum(map(goal_conversions.viewpoint_count, self._plans.values()))
        self._monitor.images_expected = expected + self._photographed
        viewpoints = goal_conversions.viewpoint_count(result.plan)
        self._monitor.begin_plan(result.plan.plan_id, viewpoints)
        self._routed = [route.vehicle for route in routed]
        real = {vehicle.name for vehicle in self._scenario.linked} & set(self._routed)
        # The rest of a plan that was confirmed needs no confirmation of its own.
        if real and not self._mission.fleet.is_gathering:
            self.unconfirmed = Confirmation(
                digest=plan_digest(result.plan.plan_id, result.plan.routes),
                what='plan',
                file='plan.json',
                text='real vehicles take off',
                accept=partial(self._mission.planned, self._routed),
                refuse=partial(self._on_refusal, Order(kind=OrderKind.PLAN)),
            )
        else:
            # Of these the image store owes a photograph each.
            taken = len(visited) if self._scenario.has_cameras else 0
            self._mission.planned(self._routed, taken)

    def _on_flight(self, plan_id: str, order: Order, future: Any) -> None:
        answer = future.result()
        # A repeated request is answered twice; the second answer may come in the next round.
        is_current = self._plan is not None and self._plan.plan_id == plan_id
        if self._mission is not None and is_current:
            result = answer.result
            fault = conversions.fault_of_flight(result)
            is_refused = result.outcome == FlyRoute.Result.REJECTED
            if not (fault or is_refused) and answer.status != GoalStatus.STATUS_SUCCEEDED:
                fault = BROKEN_OFF
            self._mission.flown(order.vehicle, result.shots_taken, fault, is_refused=is_refused)

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
