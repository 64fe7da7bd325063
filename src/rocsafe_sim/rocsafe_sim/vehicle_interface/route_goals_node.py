# SPDX-License-Identifier: Apache-2.0
"""Goals of an action that moves a simulated vehicle along a route."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from rclpy.action import ActionServer, CancelResponse

from rocsafe_ros.interfaces.interface_spec import CallSpec
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.control_lease import LeaseRefusedError
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_sim.clock.cadence import Cadence
from rocsafe_sim.errors import CommandRefusedError

FEEDBACK_PERIOD_NS = 1_000_000_000


class RouteGoals(ABC):
    """Serves an action. Several goals of one route join one movement and end with it.

    A goal that replaces the route under way ends those of that route.

    A goal is executed, in the terms of rclpy, when its movement has ended. No coroutine waits for
    that, because the executors of rclpy resume a waiting coroutine all the time.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    spec
        The action.
    lease
        Judges who may send goals.
    on_command
        Called after the vehicle got a command.

    Attributes
    ----------
    has_time
        Whether the vehicle was stepped: goals before wait for that.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        spec: CallSpec,
        lease: LeaseServer,
        on_command: Callable[[], None],
    ) -> None:
        self._node, self._lease, self._on_command = node, lease, on_command
        self.has_time = False
        self._feedbacks = Cadence(FEEDBACK_PERIOD_NS)
        self._early: list[Any] = []
        self._moving: list[Any] = []
        self._aborted: dict[bytes, Any] = {}
        self._server = ActionServer(
            node,
            spec.call_type,
            spec.name,
            execute_callback=self._execute,
            handle_accepted_callback=self._on_goal,
            cancel_callback=self._on_cancel,
        )

    def after_step(self, time_ns: int) -> None:
        """Begin accepted goals, publish feedback, and end the goals of an ended movement."""
        self.has_time = self.has_time or time_ns > 0
        while self.has_time and self._early:
            self._on_goal(self._early.pop(0))
        self.end_goals()
        if self._feedbacks.is_due(time_ns) and self._moving:
            feedback = self.feedback()
            for goal in self._moving:
                goal.publish_feedback(feedback)

    def withdraw_early(self) -> None:
        """End the goals that wait for the first step: another order came meanwhile."""
        early, self._early = self._early, []
        for goal in early:
            self._abort(goal, self.failure('withdrawn by another order', is_refusal=False))

    def end_goals(self) -> None:
        """End the goals if the movement has ended."""
        if self.result() is not None:
            ended, self._moving = self._moving, []
            for goal in ended:
                goal.execute()

    @abstractmethod
    def begin(self, request: Any) -> str:
        """Command a movement; return why the goals of the route before end, empty if they go on.

        Raises
        ------
        CommandRefusedError, ValueError
            If the vehicle refuses.
        """

    @abstractmethod
    def cancel(self) -> None:
        """End the movement by request."""

    @abstractmethod
    def result(self) -> Any:
        """Return the result of the movement, None while it goes on."""

    @abstractmethod
    def failure(self, text: str, *, is_refusal: bool) -> Any:
        """Return the result of a goal that never began, or was replaced."""

    @abstractmethod
    def feedback(self) -> Any:
        """Return the feedback of all goals."""

    def _on_goal(self, goal: Any) -> None:
        if self._lease.is_for_another(goal.request.lease):
            return  # that node executes it
        if not self.has_time:
            self._early.append(goal)
            return
        name, request = self._node.vehicle_name, goal.request
        try:
            if request.route.vehicle not in ('', name):
                raise CommandRefusedError(f'the route is for {request.route.vehicle}')  # noqa: TRY301
            self._lease.require(request.lease)
            replaced = self.begin(request)
        except (LeaseRefusedError, CommandRefusedError, ValueError) as error:
            self._abort(goal, self.failure(f'{name}: {error}', is_refusal=True))
            return
        if replaced:
            ended, self._moving = self._moving, []
            for before in ended:
                self._abort(before, self.failure(replaced, is_refusal=False))
        self._on_command()
        self._moving.append(goal)
        self.end_goals()

    def _abort(self, goal: Any, result: Any) -> None:
        self._aborted[bytes(goal.goal_id.uuid)] = result
        goal.execute()

    def _execute(self, goal: Any) -> Any:
        known = self._aborted.pop(bytes(goal.goal_id.uuid), None)
        result = self.result()
        if goal.is_cancel_requested and (known is not None or result is not None):
            goal.canceled()
            return known or result
        if known is not None or result is None:
            goal.abort()
            text = f'{self._node.vehicle_name}: the movement goes on'
            return known or self.failure(text, is_refusal=True)
        if result.outcome == type(result).COMPLETED:
            goal.succeed()
        else:
            goal.abort()
        return result

    def _on_cancel(self, goal: Any) -> CancelResponse:
        # rclpy marks the goal as being cancelled only after this callback.
        later = self._node.executor.create_task
        if any(goal is early for early in self._early):
            self._early = [early for early in self._early if early is not goal]
            text = 'cancelled before it began'
            later(self._abort, goal, self.failure(text, is_refusal=False))
            return CancelResponse.ACCEPT
        if not any(goal is moving for moving in self._moving):
            return CancelResponse.REJECT  # another node of this name executes it
        self.cancel()
        self._on_command()
        later(self.end_goals)
        return CancelResponse.ACCEPT
