# SPDX-License-Identifier: Apache-2.0
"""The action fly_route of a simulated vehicle."""

from collections.abc import Callable
from typing import Any

from rclpy.action import ActionServer, CancelResponse

from rocsafe_interfaces.action import FlyRoute
from rocsafe_ros import topics
from rocsafe_ros.control_lease import LeaseRefusedError
from rocsafe_ros.lease_server_node import LeaseServer
from rocsafe_ros.vehicle_scope import VehicleScopeNode
from rocsafe_sim.clock.cadence import Cadence
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.messages.conversions import refusal_message, result_message, route_of
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.vehicle.flight_record import FlightOutcome

FEEDBACK_PERIOD_NS = 1_000_000_000


class FlyRouteServer:
    """Serves fly_route. Several goals of one route join one flight and end with it.

    A goal that replaces the route being flown ends those of that route.

    A goal is executed, in the terms of rclpy, when its flight has ended. No coroutine waits for
    that, because the executors of rclpy resume a waiting coroutine all the time.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    rav
        The vehicle.
    lease
        Judges who may send goals.
    on_command
        Called after the vehicle got a command.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        rav: Rav,
        lease: LeaseServer,
        on_command: Callable[[], None],
    ) -> None:
        self._node = node
        self._rav = rav
        self._lease = lease
        self._on_command = on_command
        self._has_time = False
        self._feedbacks = Cadence(FEEDBACK_PERIOD_NS)
        self._early: list[Any] = []
        self._flying: list[Any] = []
        self._results: dict[bytes, FlyRoute.Result] = {}
        self._server = ActionServer(
            node,
            topics.FLY_ROUTE.call_type,
            topics.FLY_ROUTE.name,
            execute_callback=self._result,
            handle_accepted_callback=self._on_goal,
            cancel_callback=self._on_cancel,
        )

    def after_step(self, time_ns: int) -> None:
        """Begin accepted goals, publish feedback, and end the goals of an ended flight."""
        self._has_time = True
        while self._early:
            self._on_goal(self._early.pop(0))
        self.end_goals()
        if self._feedbacks.is_due(time_ns) and self._flying:
            feedback = self._feedback()
            for goal in self._flying:
                goal.publish_feedback(feedback)

    def end_goals(self) -> None:
        """End the goals if the flight has ended."""
        if self._rav.vehicle.summary() is not None:
            ended, self._flying = self._flying, []
            for goal in ended:
                goal.execute()

    def _on_goal(self, goal: Any) -> None:
        if self._lease.is_for_another(goal.request.lease):
            return  # that node executes it
        if not self._has_time:
            self._early.append(goal)
            return
        refusal = self._begin(goal.request)
        if refusal is not None:
            self._end(goal, refusal)
            return
        self._flying.append(goal)
        self.end_goals()

    def _begin(self, request: FlyRoute.Goal) -> FlyRoute.Result | None:
        """Command the flight; return the reason if it is refused."""
        name = self._rav.parts.name
        if request.route.vehicle not in ('', name):
            return refusal_message(f'{name}: the route is for {request.route.vehicle}')
        try:
            self._lease.require(request.lease)
            route = route_of(request.route, request.plan_id, self._rav.parts.frame)
            before = self._rav.vehicle.flight
            self._rav.vehicle.fly_route(route, replaces=request.replace)
        except (LeaseRefusedError, CommandRefusedError, ValueError) as error:
            return refusal_message(f'{name}: {error}')
        if before is not None and before.route != route:
            self._end_replaced(request.plan_id)
        self._on_command()
        return None

    def _end_replaced(self, plan_id: str) -> None:
        """End the goals of a replaced route."""
        text = f'plan {plan_id} is flown in its place'
        ended, self._flying = self._flying, []
        for goal in ended:
            self._end(goal, FlyRoute.Result(outcome=FlyRoute.Result.ABORTED, error_msg=text))

    def _end(self, goal: Any, result: FlyRoute.Result) -> None:
        self._results[bytes(goal.goal_id.uuid)] = result
        goal.execute()

    def _result(self, goal: Any) -> FlyRoute.Result:
        known = self._results.pop(bytes(goal.goal_id.uuid), None)
        summary = self._rav.vehicle.summary()
        if known is not None or summary is None:
            goal.abort()
            return known or refusal_message(f'{self._rav.parts.name}: the flight goes on')
        if goal.is_cancel_requested:
            goal.canceled()
        elif summary.outcome is FlightOutcome.COMPLETED:
            goal.succeed()
        else:
            goal.abort()
        return result_message(summary)

    def _on_cancel(self, _goal: Any) -> CancelResponse:
        self._rav.vehicle.cancel()
        self._on_command()
        # rclpy marks the goal as being cancelled only after this callback.
        self._node.executor.create_task(self.end_goals)
        return CancelResponse.ACCEPT

    def _feedback(self) -> FlyRoute.Feedback:
        flight = self._rav.vehicle.flight
        left_m, left_s = self._rav.vehicle.left()
        return FlyRoute.Feedback(
            viewpoint_index=0 if flight is None else flight.visited,
            viewpoint_count=0 if flight is None else len(flight.route.waypoints),
            distance_left_m=left_m,
            time_left_s=left_s,
        )
