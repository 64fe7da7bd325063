# SPDX-License-Identifier: Apache-2.0
"""Requests to the localizer, the router and the ground vehicle of a mission."""

from collections.abc import Sequence
from functools import partial
from typing import Any

from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.node import Node

from rocsafe_interfaces.action import DriveRoute, PlanGroundRoute
from rocsafe_interfaces.msg import GroundRoute
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_orchestrator.goal_requests_node import GoalRequests
from rocsafe_orchestrator.mission.driving import DriveEnd
from rocsafe_orchestrator.mission.request import Order
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.parameters.drive_goal import DriveSoFar, drive_goal, drive_text
from rocsafe_ros import calls
from rocsafe_ros.interface_spec import name_of
from rocsafe_ros.lease_holder_node import Leases
from rocsafe_scenario.scenario import Scenario

# How a drive ends on the road.
_OUT = (DriveRoute.Result.BLOCKED, DriveRoute.Result.DOSE_UNEXPECTED)


class DriveRequests(GoalRequests):
    """Clients of the drive of a ground vehicle.

    Actions: ``plan_ground_route``, ``<vehicle>/drive_route``. Services:
    ``hazard/suggest_viewpoints`` and ``hazard/suggest_gas_viewpoints``, whose answers mean that
    all readings are assessed.

    Parameters
    ----------
    node
        Node that owns the clients.
    scenario
        With a ground vehicle.
    monitor
        Knows sources and releases; gets the number of photographs to expect.
    leases
        Of the vehicles.
    assessors
        Clients of the services.
    """

    def __init__(
        self,
        node: Node,
        scenario: Scenario,
        monitor: Monitor,
        leases: Leases,
        assessors: Sequence[Client],
    ) -> None:
        super().__init__('router')
        self._scenario, self._monitor = scenario, monitor
        self._leases, self._assessors = leases, tuple(assessors)
        self._unassessed: list[Client] = []
        self._so_far = DriveSoFar()
        self._route: GroundRoute | None = None
        driver = scenario.driver_name
        self.router = ActionClient(node, PlanGroundRoute, calls.PLAN_GROUND_ROUTE.name)
        self.vehicle = ActionClient(node, DriveRoute, name_of(calls.DRIVE_ROUTE, driver))

    def close(self) -> None:
        """Destroy the clients of actions."""
        self.router.destroy()
        self.vehicle.destroy()

    def send_assess(self, order: Order) -> None:
        """Ask whether all readings are assessed; repeated until they are, before each drive."""
        if not self._unassessed:
            self._unassessed = list(self._assessors)
        for assessor in tuple(self._unassessed):
            answer = assessor.call_async(SuggestViewpoints.Request(count=1))
            answer.add_done_callback(partial(self._on_assessed, order, assessor))

    def _on_assessed(self, order: Order, assessor: Client, future: Any) -> None:
        answer = future.result()
        if self._mission is None or answer is None or answer.status == answer.NOT_YET:
            return
        if assessor not in self._unassessed:
            return
        self._unassessed.remove(assessor)
        if not self._unassessed:
            self._mission.answered(order)

    def send_plan(self, order: Order) -> None:
        """Ask for a route to the evidence that is not taken yet."""
        goal = self._goal()
        if goal is None:
            self._refuse(order, 'no drive: nothing was found, and no evidence is named')
            return
        self._send_goal(self.router, goal, order, self._on_route)

    def send_drive(self, order: Order) -> None:
        """Send the route to the vehicle."""
        if self._route is None:
            return
        goal = DriveRoute.Goal(route=self._route)

        def send(lease: str) -> None:
            goal.lease = lease
            self._send_goal(self.vehicle, goal, order, self._on_driven)

        self._leases.carry(order.vehicle, send, partial(self._refuse, order))

    def _on_route(self, order: Order, future: Any) -> None:
        result = future.result().result
        if self._mission is None:
            return
        if result.error_code != result.NONE:
            self._refuse(order, f'router: {result.error_msg}')
            return
        self._route = result.route
        if not self._so_far.evidence:
            planned = sum(bool(stop.evidence) for stop in result.route.stops)
            self._monitor.images_expected += planned
        self._mission.remarks.append(drive_text(result.route))
        self._mission.drive_planned()

    def _on_driven(self, order: Order, future: Any) -> None:
        result = future.result().result
        if self._mission is None:
            return
        if result.outcome == DriveRoute.Result.REJECTED:
            self._refuse(order, result.error_msg)
            return
        self._so_far = self._so_far.after(result)
        ending = DriveEnd.AT_HOME
        if result.outcome in _OUT:
            is_left = self._goal() is not None
            ending = DriveEnd.OUT_WITH_EVIDENCE_LEFT if is_left else DriveEnd.OUT_WITH_ALL
        self._mission.driven(result.error_msg, ending)

    def _goal(self) -> PlanGroundRoute.Goal | None:
        monitor = self._monitor
        return drive_goal(self._scenario, monitor.sources, monitor.releases, self._so_far)
