# SPDX-License-Identifier: Apache-2.0
"""Goals of an action that moves a real vehicle along a route."""

import time
from abc import ABC, abstractmethod
from typing import Any

from rclpy.action import ActionServer, CancelResponse

from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.flight_record import FlightSummary
from rocsafe_mavlink.errors import CommandRefusedError, WaitError
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.vehicle_interface.node_timing import TIMING
from rocsafe_ros.interfaces.interface_spec import CallSpec
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.control_lease import LeaseRefusedError
from rocsafe_ros.lease.server_node import LeaseServer


class RouteGoals(ABC):
    """Serves an action: any number of goals may join one flight or drive, and all end with it.

    A goal is executed, as rclpy calls it, when its result is known.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    spec
        The action.
    drone
        The vehicle.
    lease
        Judges who may send goals.
    """

    def __init__(
        self, node: VehicleScopeNode, spec: CallSpec, drone: Drone, lease: LeaseServer
    ) -> None:
        self._drone, self._lease = drone, lease
        self._now_s = self._feedback_s = 0.0
        self._early: list[tuple[Any, float, int]] = []
        self._moving: list[Any] = []
        self._cancelling: list[tuple[Any, int]] = []
        self._replacing: tuple[Any, Assignment, int] | None = None
        self._results: dict[bytes, Any] = {}
        self._server = ActionServer(
            node,
            spec.call_type,
            spec.name,
            execute_callback=self._result,
            handle_accepted_callback=self._on_goal,
            cancel_callback=self._on_cancel,
        )

    def step(self, now_s: float, *, is_supervised: bool) -> None:  # noqa: ARG002 (of delays)
        """Begin routes, give feedback, and end the goals of a route that has ended."""
        self._now_s = now_s
        early, self._early = self._early, []
        for goal, since_s, withdrawals in early:
            if withdrawals != self._drone.session.withdrawals:
                self.refuse(goal, self.withdrawal())
            else:
                self._begin(goal, since_s)
        self._watch_replacement()
        self._watch_cancelling()
        summary = self._drone.summary()
        if summary is not None and self._moving:
            self._end_all(summary)
        if self._moving and now_s - self._feedback_s >= TIMING.feedback_s:
            self._feedback_s = now_s
            feedback = self.feedback()
            for goal in self._moving:
                goal.publish_feedback(feedback)

    def accept(self, goal: Any) -> None:
        """Let a goal begin at the next step."""
        self.keep(goal, self.now_s())

    @abstractmethod
    def assignment(self, request: Any) -> Assignment:
        """Return the plan of a goal.

        Raises
        ------
        ValueError
            Naming what cannot be flown or driven.
        """

    def start_refusal(self, _request: Any) -> str:
        """Return why a goal may not start the vehicle from rest; empty if it may."""
        return ''

    @abstractmethod
    def result(self, goal: Any, summary: FlightSummary) -> Any:
        """Return the result of a goal whose route has ended."""

    @abstractmethod
    def failure(self, goal: Any, text: str, outcome: str) -> Any:
        """Return the result of a goal before the end of its route; `outcome` is its name."""

    @abstractmethod
    def feedback(self) -> Any:
        """Return the feedback of all goals."""

    def now_s(self) -> float:
        """Return the time of the step, steady seconds."""
        return self._now_s or time.monotonic()

    def keep(self, goal: Any, since_s: float) -> None:
        """Let a goal begin at the next step, unless a command withdraws its start before."""
        self._early.append((goal, since_s, self._drone.session.withdrawals))

    def withdrawal(self) -> str:
        """Return why goals that have not begun are given up."""
        return f'its start was withdrawn: {self._drone.session.withdrawn_by}'

    def refuse(self, goal: Any, reason: str) -> None:
        """End a goal that does not begin."""
        self._end(goal, self.failure(goal, f'{self._drone.spec.name}: {reason}', 'REJECTED'))

    def is_early(self, goal: Any) -> bool:
        """Whether a goal was accepted and has not begun."""
        return any(goal is one for one, _since_s, _withdrawals in self._early)

    def _on_goal(self, goal: Any) -> None:
        if not self._lease.is_for_another(goal.request.lease):  # else that node executes it
            self.accept(goal)

    def _begin(self, goal: Any, since_s: float) -> None:
        """Begin the route, or say why not; a goal that cannot be judged yet waits."""
        request, drone = goal.request, self._drone
        if request.route.vehicle not in ('', drone.spec.name):
            self.refuse(goal, f'the route is for {request.route.vehicle}')
            return
        try:
            self._lease.require(request.lease)
            assignment = self.assignment(request)
            if request.replace and drone.flies_another(assignment):
                drone.replace_route(assignment, self._now_s)
                self._replacing = (goal, assignment, drone.commands.count)
                return
            if refusal := self.start_refusal(request):
                self.refuse(goal, refusal)
                return
            drone.fly(assignment, self._now_s)
        except WaitError as reason:
            if self._now_s - since_s > TIMING.goal_wait_s:
                self.refuse(goal, str(reason))
            else:
                self.keep(goal, since_s)
            return
        except (LeaseRefusedError, CommandRefusedError, ValueError) as error:
            self.refuse(goal, str(error))
            return
        self._moving.append(goal)

    def _watch_replacement(self) -> None:
        """Switch to the new route when it is under way, or say why it is not."""
        if self._replacing is None:
            return
        goal, assignment, number = self._replacing
        error = self._drone.commands.outcome(number)
        if error is None:
            return
        self._replacing = None
        if error:
            self.refuse(goal, error)
            return
        self._end_all(f'plan {assignment.plan_id} takes its place')
        self._drone.switch_to(assignment)
        self._moving.append(goal)

    def _on_cancel(self, goal: Any) -> CancelResponse:
        """Hold; the goal ends when the vehicle holds, or has refused to."""
        if self.is_early(goal):
            self._drone.session.withdraw_start('cancel')
            return CancelResponse.ACCEPT
        is_replacing = self._replacing is not None and goal is self._replacing[0]
        if goal not in self._moving and not is_replacing:
            return CancelResponse.REJECT
        try:
            self._drone.commands.hold(self._now_s)
        except CommandRefusedError:
            return CancelResponse.REJECT
        self._cancelling.append((goal, self._drone.commands.count))
        return CancelResponse.ACCEPT

    def _watch_cancelling(self) -> None:
        waiting, self._cancelling = self._cancelling, []
        for goal, number in waiting:
            error = self._drone.commands.outcome(number)
            if error is None:
                self._cancelling.append((goal, number))
            elif goal in self._moving:
                self._moving.remove(goal)
                text = error or 'cancelled by request: the vehicle holds'
                self._end(goal, self.failure(goal, text, 'ABORTED' if error else 'CANCELLED'))

    def _end_all(self, how: FlightSummary | str) -> None:
        """End all goals, by how their route ended or by why it is given up."""
        ended, self._moving = self._moving, []
        for goal in ended:
            if isinstance(how, str):
                self._end(goal, self.failure(goal, how, 'ABORTED'))
            else:
                self._end(goal, self.result(goal, how))

    def _end(self, goal: Any, result: Any) -> None:
        self._results[bytes(goal.goal_id.uuid)] = result
        goal.execute()

    def _result(self, goal: Any) -> Any:
        result = self._results.pop(bytes(goal.goal_id.uuid))
        if goal.is_cancel_requested:
            goal.canceled()
        elif result.outcome == result.COMPLETED:
            goal.succeed()
        else:
            goal.abort()
        return result
