# SPDX-License-Identifier: Apache-2.0
"""Requests to the localizer, the router and the ground vehicle of a mission."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from rclpy.action import ActionClient
from rclpy.client import Client
from rclpy.node import Node

from rocsafe_interfaces.action import DriveRoute, PlanGroundRoute
from rocsafe_interfaces.msg import GroundRoute
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_orchestrator.mission.drive_watch import DriveWatch, Reading
from rocsafe_orchestrator.mission.driving import DriveEnd
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.parameters.drive_goal import (
    DriveSoFar,
    Found,
    dose_change,
    drive_goal,
    drive_text,
    drive_watch,
    task_digest,
)
from rocsafe_orchestrator.requests.goal_requests_node import GoalRequests
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.interface_spec import name_of
from rocsafe_ros.lease.holder_node import Leases
from rocsafe_scenario.scenario import Scenario

# How a drive ends on the road.
# A route is planned anew if its dose is known to be so many times larger, or smaller: as when the
# vehicle itself reads so much more or less than predicted.
MOST_TIMES = 2.0
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
    call_home
        Tells the vehicle to return.

    Attributes
    ----------
    unconfirmed
        Hash of the task of a real vehicle, until it is confirmed; empty: none waits.
    """

    def __init__(
        self,
        node: Node,
        scenario: Scenario,
        monitor: Monitor,
        leases: Leases,
        assessors: Sequence[Client],
        call_home: Callable[[], None] = lambda: None,
    ) -> None:
        super().__init__('router')
        self._scenario, self._monitor = scenario, monitor
        self._leases, self._assessors = leases, tuple(assessors)
        self._unassessed: list[Client] = []
        self._so_far = DriveSoFar()
        # Photographs of evidence that the last plan expects, with those already taken.
        self._photographs = 0
        self._route: GroundRoute | None = None
        self._driving: Any = None
        self._planned_on: Found = ()
        self._outdated = ''
        self._call_home, self._called_home = call_home, ''
        # Over a real vehicle, also while it waits for its next route; of which route, and the
        # dose that belongs to the drives before.
        self._watch: DriveWatch | None = None
        self._watched: GroundRoute | None = None
        self._told_usv = 0.0
        self.unconfirmed, self._is_confirmed = '', False
        self._waiting = Order(kind=OrderKind.PLAN_DRIVE)
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
        self._planned_on = self._monitor.sources
        self._so_far = self._so_far.asked(goal.evidence)
        self._send_goal(self.router, goal, order, self._on_route)

    def send_drive(self, order: Order) -> None:
        """Send the route to the vehicle."""
        if self._route is None:
            return
        goal = DriveRoute.Goal(route=self._route)
        if self._is_real and self._watched is not self._route:
            waited_usv = self._watch.dose_usv - self._told_usv if self._watch else 0.0
            self._watch = drive_watch(self._route, waited_usv)
            self._watched, self._told_usv, self._called_home = self._route, 0.0, ''

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
        if self._so_far.objects is None:
            self._so_far = replace(self._so_far, objects=tuple(result.objects))
        photographs = len(self._so_far.evidence)
        photographs += sum(bool(stop.evidence) for stop in result.route.stops)
        self._monitor.images_expected += photographs - self._photographs
        self._photographs = photographs
        self._mission.remarks.append(drive_text(result.route))
        # What is planned anew on the way is within the task that was confirmed.
        if self._is_real and not self._is_confirmed:
            self.unconfirmed, self._waiting = task_digest(self._scenario), order
        else:
            self._mission.drive_planned()

    @property
    def _is_real(self) -> bool:
        return self._scenario.driver_name in self._scenario.real_names

    def confirm(self) -> None:
        """Drive the route that waits for a confirmation of its task."""
        self.unconfirmed, self._is_confirmed = '', True
        if self._mission is not None:
            self._mission.drive_planned()

    def reject(self, text: str) -> None:
        """Refuse the route that waits for a confirmation of its task, with the reason."""
        self.unconfirmed = ''
        self._refuse(self._waiting, text)

    def on_reading(self, reading: Reading) -> None:
        """Take a reading of the ground vehicle; call a real one home in time."""
        why = self._watch.read(reading) if self._watch is not None else ''
        if why and self._driving is not None and not self._called_home:
            self._called_home = f'called home for its dose: {why}'
            self._call_home()

    def on_sources(self) -> None:
        """Stop a drive that by the sources known now takes much more dose, or much less."""
        if self._driving is None or self._route is None or self._outdated:
            return
        times = dose_change(self._route, self._planned_on, self._monitor.sources)
        if not 1.0 / MOST_TIMES <= times <= MOST_TIMES:
            self._outdated = f'by the sources known now it takes {times:.2g} times the dose'
            self._driving.cancel_goal_async()

    def _on_driven(self, order: Order, future: Any) -> None:
        result = future.result().result
        if self._mission is None:
            return
        if result.outcome == DriveRoute.Result.REJECTED:
            self._refuse(order, result.error_msg)
            return
        if self._watch is not None:
            # A real vehicle does not know its dose.
            result.dose_usv = self._told_usv = self._watch.dose_usv
            result.duration_s = max(result.duration_s, self._watch.duration_s)
        self._so_far = self._so_far.after(result)
        self._driving, outdated, self._outdated = None, self._outdated, ''
        is_stopped = result.outcome == DriveRoute.Result.CANCELLED and bool(outdated)
        is_stopped &= not self._called_home
        text = outdated if is_stopped else self._called_home or result.error_msg
        ending = DriveEnd.AT_HOME
        if is_stopped or result.outcome in _OUT:
            is_left = self._goal() is not None
            ending = DriveEnd.OUT_WITH_EVIDENCE_LEFT if is_left else DriveEnd.OUT_WITH_ALL
        self._mission.driven(text, ending)

    def _on_goal(self, order: Order, on_result: Callable[..., None], future: Any) -> None:
        handle = future.result()
        if order.kind is OrderKind.DRIVE and handle is not None and handle.accepted:
            self._driving = handle
        super()._on_goal(order, on_result, future)

    def _goal(self) -> PlanGroundRoute.Goal | None:
        monitor = self._monitor
        return drive_goal(
            self._scenario,
            monitor.sources,
            monitor.releases,
            self._so_far,
            monitor.marks(),
            monitor.release_unit,
        )
