# SPDX-License-Identifier: Apache-2.0
"""Requests to the nodes that fly a mission, and their answers."""

from collections.abc import Callable
from functools import partial
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.node import Node
from std_srvs.srv import SetBool, Trigger

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import StepDone
from rocsafe_interfaces.srv import FleetCommand, Resume
from rocsafe_orchestrator import conversions
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.status import FlightState, Monitor
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.parameters.node_parameters import AGENTS, FLEET
from rocsafe_orchestrator.process_table.table import Endpoint
from rocsafe_orchestrator.requests.advice_requests_node import AdviceRequests
from rocsafe_orchestrator.requests.drive_requests_node import DriveRequests
from rocsafe_orchestrator.requests.goal_requests_node import GoalRequests
from rocsafe_orchestrator.requests.plan_requests_node import BROKEN_OFF, PlanRequests
from rocsafe_orchestrator.watches.operator_watch import Verb
from rocsafe_orchestrator.watches.retreat import retreat
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import CallSpec, name_of
from rocsafe_ros.lease.holder_node import Leases
from rocsafe_ros.plan_digest import route_digest
from rocsafe_scenario.scenario import Scenario

SERVICES = (
    calls.WORLD_RUN,
    calls.SAVE_MOSAIC,
    calls.SUGGEST_VIEWPOINTS,
    calls.SUGGEST_GAS_VIEWPOINTS,
    calls.FLEET_HOLD,
    calls.FLEET_RETURN_HOME,
)
_VERBS = {
    OrderKind.HOLD: calls.HOLD,
    OrderKind.RESUME: calls.RESUME,
    OrderKind.RETURN: calls.RETURN_HOME,
}


_ON_ROUTE = frozenset({FlightState.WAITING, FlightState.TAKING_OFF, FlightState.FLYING})


class Requests(GoalRequests):
    """Clients of the planner, the vehicles, the world, the map maker, localizer and estimator.

    Actions: ``plan_survey``, ``<vehicle>/fly_route``. Services: ``<vehicle>/hold``,
    ``<vehicle>/resume``, ``<vehicle>/return_home``, ``world/run``, ``mosaic/save``.

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
    plans
        The plans of the mission.
    drives
        The drives of its ground vehicle; None: it has none.
    """

    def __init__(self, node: Node, scenario: Scenario, monitor: Monitor, mission_id: str) -> None:
        super().__init__('planner')
        self._scenario = scenario
        self._monitor = monitor
        self._vehicles = {
            name: ActionClient(node, FlyRoute, name_of(calls.FLY_ROUTE, name))
            for name in scenario.vehicle_names
        }
        self._leases = Leases(
            node, scenario.all_names, mission_id, self._remark, role='orchestrator'
        )
        self._services: dict[str, Client] = {
            spec.name: node.create_client(spec.call_type, spec.name) for spec in SERVICES
        }
        self._verbs: dict[tuple[OrderKind, str], Client] = {
            (kind, name): node.create_client(spec.call_type, name_of(spec, name))
            for kind, spec in _VERBS.items()
            for name in scenario.all_names
        }
        self._advice = AdviceRequests(self._services, scenario)
        self.plans = PlanRequests(node, scenario, monitor, self._advice)
        self.drives = self._drives_of(node) if scenario.driver_name else None
        self._steps = topics.create_publisher(node, topics.STEP_DONE)
        self._real = {vehicle.name for vehicle in scenario.linked}
        self._send: dict[OrderKind, Callable[[Order], None]] = {
            OrderKind.PLAN: self.plans.send,
            OrderKind.FLY: self._send_fly,
            OrderKind.ADVISE: self._advice.send,
            OrderKind.HOLD: self._send_verb,
            OrderKind.RESUME: self._send_resume,
            OrderKind.RETURN: self._send_verb,
            OrderKind.RETREAT: self._send_retreat,
            OrderKind.DISMISS: self._dismiss,
            OrderKind.PAUSE_CLOCK: self._pause,
            OrderKind.RUN_CLOCK: partial(self._call, calls.WORLD_RUN, SetBool.Request(data=True)),
            OrderKind.SAVE_MOSAIC: partial(self._call, calls.SAVE_MOSAIC, Trigger.Request()),
        }

        if self.drives is not None:
            self._send |= {
                OrderKind.ASSESS: self.drives.send_assess,
                OrderKind.PLAN_DRIVE: self.drives.send_plan,
                OrderKind.DRIVE: self.drives.send_drive,
            }

    def _drives_of(self, node: Node) -> DriveRequests:
        asked = [calls.SUGGEST_VIEWPOINTS]
        if self._scenario.air.reads:
            asked.append(calls.SUGGEST_GAS_VIEWPOINTS)
        assessors = [self._services[spec.name] for spec in asked]
        home = Order(kind=OrderKind.RETURN, vehicle=self._scenario.driver_name)
        call_home = partial(self._send_verb, home)
        return DriveRequests(
            node, self._scenario, self._monitor, self._leases, assessors, call_home
        )

    def begin(self, mission: Mission) -> None:
        """Report answers to `mission` from now on."""
        super().begin(mission)
        self.plans.begin(mission)
        self._advice.begin(mission)
        if self.drives is not None:
            self.drives.begin(mission)

    def ask_again(self) -> None:
        """Ask again for the results that have not come for long."""
        super().ask_again()
        self.plans.ask_again()
        if self.drives is not None:
            self.drives.ask_again()

    def replan(self) -> str:
        """Have the rest of the mission planned anew; return why not, empty if it is."""
        if self._mission is None:
            return 'cannot plan anew: no mission has begun'
        return self._mission.takeover.replan(self.led_by_others)

    @property
    def led_by_others(self) -> frozenset[str]:
        """Vehicles whose lease somebody outside of the mission has taken."""
        return frozenset(self._leases.led_by_others)

    def close(self) -> None:
        """Destroy the clients of actions, which keep their node in the graph."""
        for client in (self.plans.client, *self._vehicles.values()):
            client.destroy()
        if self.drives is not None:
            self.drives.close()

    def send(self, order: Order) -> None:
        """Send `order` to the node that carries it out."""
        self._send[order.kind](order)

    def is_ready(self, endpoint: Endpoint) -> bool:
        """Return whether the server of a service or an action can be reached."""
        if endpoint.kind == 'service':
            return bool(self._services[endpoint.name].service_is_ready())
        if self.drives is not None and endpoint.spec is calls.PLAN_GROUND_ROUTE:
            return bool(self.drives.router.server_is_ready())
        if self.drives is not None and endpoint.spec is calls.DRIVE_ROUTE:
            return bool(self.drives.vehicle.server_is_ready())
        client = self._vehicles.get(endpoint.vehicle, self.plans.client)
        return bool(client.server_is_ready())

    def command_fleet(self, verb: Verb, vehicles: list[str]) -> None:
        """Command some vehicles, and report their refusals."""
        spec = calls.FLEET_HOLD if verb is Verb.HOLD else calls.FLEET_RETURN_HOME
        answer = self._services[spec.name].call_async(FleetCommand.Request(vehicles=vehicles))
        answer.add_done_callback(self._on_fleet)

    def _on_fleet(self, future: Any) -> None:
        for answer in future.result().answers:
            if answer.message:
                self._remark(answer.message)

    def _send_fly(self, order: Order) -> None:
        plan = self.plans.plan
        if plan is None:
            return
        route = self.plans.routes[plan.plan_id, order.vehicle]
        if not route.viewpoints and order.vehicle in self._real and self._mission is not None:
            self._mission.takeover.sent_home(order.vehicle)
            return
        goal = FlyRoute.Goal(
            route=route,
            plan_id=plan.plan_id,
            replace=self.plans.replaces,
        )
        self._send_flight(order, goal, partial(self._on_flight, plan.plan_id))

    def _send_flight(
        self, order: Order, goal: FlyRoute.Goal, on_result: Callable[..., None]
    ) -> None:
        def send(lease: str) -> None:
            goal.lease = lease
            goal.confirmation = route_digest(goal.plan_id, goal.route)
            self._send_goal(self._vehicles[order.vehicle], goal, order, on_result)

        self._leases.carry(order.vehicle, send, partial(self._refuse, order))

    def _send_retreat(self, order: Order) -> None:
        """Call a vehicle home by the way of least dose; over terrain by its own way."""
        status = self._monitor.vehicle(order.vehicle)
        route = self.plans.routes.get((status.plan_id, order.vehicle))
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
        if result.outcome == result.REJECTED:
            self._refuse(order, f'{order.vehicle}: {result.error_msg}')

    def _send_resume(self, order: Order) -> None:
        """Let a vehicle that was told to hold go on: its route again moves nothing.

        A simulated one that is on its way, or waits on the ground unheld, is not disturbed by it.
        """
        state = self._monitor.vehicle(order.vehicle).state
        is_simulated = order.vehicle not in self._real
        if not (state is FlightState.HOLDING or (is_simulated and state in _ON_ROUTE)):
            if self._mission is not None:
                self._mission.answered(order)
            return

        def send(lease: str) -> None:
            answer = self._verbs[order.kind, order.vehicle].call_async(Resume.Request(lease=lease))
            answer.add_done_callback(partial(self._on_answer, calls.RESUME, order))

        self._leases.carry(order.vehicle, send, partial(self._refuse, order))

    def _send_verb(self, order: Order) -> None:
        if order.vehicle in self.led_by_others:
            self._refuse(order, f'{order.vehicle}: somebody else leads it')
            return
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
            self._call(calls.WORLD_RUN, SetBool.Request(data=False), order)
        elif self._mission is not None:
            self._mission.answered(order)

    def _on_flight(self, plan_id: str, order: Order, future: Any) -> None:
        answer = future.result()
        # A repeated request is answered twice; the second answer may come in the next round.
        is_current = self.plans.plan is not None and self.plans.plan.plan_id == plan_id
        if self._mission is not None and is_current:
            result = answer.result
            fault = conversions.fault_of_flight(result)
            is_refused = result.outcome == FlyRoute.Result.REJECTED
            if not (fault or is_refused) and answer.status != GoalStatus.STATUS_SUCCEEDED:
                fault = BROKEN_OFF
            self._mission.flown(order.vehicle, result.shots_taken, fault, is_refused=is_refused)

    def _call(self, spec: CallSpec, request: Any, order: Order) -> None:
        client = self._services[spec.name]
        client.call_async(request).add_done_callback(partial(self._on_answer, spec, order))

    def _on_answer(self, spec: CallSpec, order: Order, future: Any) -> None:
        answer = future.result()
        if self._mission is None or answer is None:
            return
        if answer.success:
            self._mission.answered(order)
        else:
            self._mission.refused(order, f'{spec.name}: {answer.message}')
