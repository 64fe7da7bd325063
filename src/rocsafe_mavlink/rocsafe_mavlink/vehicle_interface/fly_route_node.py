# SPDX-License-Identifier: Apache-2.0
"""The action fly_route of a real vehicle."""

import time
from collections.abc import Callable
from typing import Any

from rclpy.action import ActionServer, CancelResponse

from rocsafe_interfaces.action import FlyRoute
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.errors import CommandRefusedError, WaitError
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.flight.late_start import LateStart
from rocsafe_mavlink.vehicle_interface.conversions import assignment_of, delay_of
from rocsafe_mavlink.vehicle_interface.node_timing import TIMING
from rocsafe_mavlink.vehicle_interface.result_conversions import (
    cancelled_message,
    refusal_message,
    result_message,
)
from rocsafe_ros import calls
from rocsafe_ros.lease.control_lease import LeaseRefusedError
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_ros.plan_digest import route_digest
from rocsafe_ros.vehicle_scope import VehicleScopeNode


class FlyRouteServer:
    """Serves fly_route: any number of goals may join one flight, and all end with it.

    A goal with a delay is begun so long after it came, on the ground or in the air. It is given up
    if the vehicle is told to hold, return or land meanwhile, if another route comes, or if nobody
    supervises the flight any more.

    A goal is executed, as rclpy calls it, when its result is known.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    drone
        The vehicle.
    lease
        Judges who may send goals.
    shots
        Returns how many photographs the store must get, of so many viewpoints visited.
    late_start
        Keeps when a goal with a delay is due.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        drone: Drone,
        lease: LeaseServer,
        shots: Callable[[int], int],
        late_start: LateStart,
    ) -> None:
        self._late_start = late_start
        self._drone = drone
        self._lease = lease
        self._shots = shots
        self._now_s = 0.0
        self._feedback_s = 0.0
        self._early: list[tuple[Any, float, int]] = []
        self._late: tuple[list[Any], float] | None = None
        self._flying: list[Any] = []
        self._cancelling: list[tuple[Any, int]] = []
        self._replacing: tuple[Any, Assignment, int] | None = None
        self._results: dict[bytes, FlyRoute.Result] = {}
        self._server = ActionServer(
            node,
            calls.FLY_ROUTE.call_type,
            calls.FLY_ROUTE.name,
            execute_callback=self._result,
            handle_accepted_callback=self._on_goal,
            cancel_callback=self._on_cancel,
        )

    def step(self, now_s: float, *, is_supervised: bool = True) -> None:
        """Begin flights, give feedback, and end the goals of a flight that has ended."""
        self._now_s = now_s
        self._watch_late(is_supervised=is_supervised)
        early, self._early = self._early, []
        for goal, since_s, withdrawals in early:
            if withdrawals != self._drone.session.withdrawals:
                why = f'{self._drone.spec.name}: {self._withdrawal()}'
                self._end(goal, refusal_message(why))
            else:
                self._begin(goal, since_s)
        self._watch_replacement()
        self._watch_cancelling()
        summary = self._drone.summary()
        if summary is not None and self._flying:
            self._end_all(result_message(summary, self._shots(summary.visited)))
        if self._flying and now_s - self._feedback_s >= TIMING.feedback_s:
            self._feedback_s = now_s
            feedback = self._feedback()
            for goal in self._flying:
                goal.publish_feedback(feedback)

    def _on_goal(self, goal: Any) -> None:
        if self._lease.is_for_another(goal.request.lease):
            return  # that node executes it
        now_s, name = self._now_s or time.monotonic(), self._drone.spec.name
        try:
            # A goal without the lease neither waits nor ends the wait of another.
            self._lease.require(goal.request.lease)
            delay_s = delay_of(goal.request.route)
        except (LeaseRefusedError, ValueError) as error:
            self._end(goal, refusal_message(f'{name}: {error}'))
            return
        if self._late is not None and _is_same(self._late[0][0].request, goal.request):
            self._late[0].append(goal)
            return
        self._end_late('another route came')
        if delay_s > 0.0:
            try:
                due_s = self._late_start.due_s(_key(goal.request), now_s, delay_s)
            except OSError as error:
                why = f'its delay cannot be kept over a restart: {error}'
                self._end(goal, refusal_message(f'{name}: {why}'))
                return
            self._late = ([goal], due_s)
            self._drone.wait_until(due_s)
        else:
            self._keep(goal, now_s)

    def _keep(self, goal: Any, since_s: float) -> None:
        """Let a goal begin at the next step, unless a command withdraws its start before."""
        self._early.append((goal, since_s, self._drone.session.withdrawals))

    def _withdrawal(self) -> str:
        return f'its start was withdrawn: {self._drone.session.withdrawn_by}'

    def _watch_late(self, *, is_supervised: bool) -> None:
        """Begin the goals with a delay when they are due, or give them up."""
        if self._late is None:
            return
        goals, due_s = self._late
        if not self._drone.is_waiting:
            self._end_late(self._withdrawal())
        elif not is_supervised:
            self._end_late('nobody supervises the mission')
        elif self._now_s >= due_s:
            self._late = None
            self._drone.wait_until(None)
            for goal in goals:
                self._keep(goal, self._now_s)

    def _end_late(self, why: str) -> None:
        """Give up the goals with a delay, if there are any."""
        if self._late is None:
            return
        (goals, _due_s), self._late = self._late, None
        self._late_start.forget()
        self._drone.wait_until(None)
        for goal in goals:
            self._end(goal, refusal_message(f'{self._drone.spec.name}: {why}'))

    def _begin(self, goal: Any, since_s: float) -> None:
        """Begin the flight, or say why not; a goal that cannot be judged yet waits."""
        request, name = goal.request, self._drone.spec.name
        if request.route.vehicle not in ('', name):
            self._end(goal, refusal_message(f'{name}: the route is for {request.route.vehicle}'))
            return
        try:
            self._lease.require(request.lease)
            assignment = assignment_of(request.route, request.plan_id, self._drone.spec)
            if request.replace and self._drone.flies_another(assignment):
                self._drone.replace_route(assignment, self._now_s)
                self._replacing = (goal, assignment, self._drone.commands.count)
                return
            _require_confirmed(request)
            self._drone.fly(assignment, self._now_s)
        except WaitError as reason:
            if self._now_s - since_s > TIMING.goal_wait_s:
                self._end(goal, refusal_message(f'{name}: {reason}'))
            else:
                self._keep(goal, since_s)
            return
        except (LeaseRefusedError, CommandRefusedError, ValueError) as error:
            self._end(goal, refusal_message(f'{name}: {error}'))
            return
        self._flying.append(goal)

    def _watch_replacement(self) -> None:
        """Switch to the new route when it is flown, or say why it is not."""
        if self._replacing is None:
            return
        goal, assignment, number = self._replacing
        error = self._drone.commands.outcome(number)
        if error is None:
            return
        self._replacing = None
        if error:
            self._end(goal, refusal_message(f'{self._drone.spec.name}: {error}'))
            return
        text = f'plan {assignment.plan_id} is flown in its place'
        self._end_all(FlyRoute.Result(outcome=FlyRoute.Result.ABORTED, error_msg=text))
        self._drone.switch_to(assignment)
        self._flying.append(goal)

    def _end_all(self, result: FlyRoute.Result) -> None:
        ended, self._flying = self._flying, []
        for goal in ended:
            self._end(goal, result)

    def _end(self, goal: Any, result: FlyRoute.Result) -> None:
        self._results[bytes(goal.goal_id.uuid)] = result
        goal.execute()

    def _result(self, goal: Any) -> FlyRoute.Result:
        result = self._results.pop(bytes(goal.goal_id.uuid))
        if goal.is_cancel_requested:
            goal.canceled()
        elif result.outcome == FlyRoute.Result.COMPLETED:
            goal.succeed()
        else:
            goal.abort()
        return result

    def _on_cancel(self, goal: Any) -> CancelResponse:
        """Hold; the goal ends when the vehicle holds, or has refused to."""
        is_late = self._late is not None and goal in self._late[0]
        if is_late or any(goal is one for one, _since_s, _withdrawals in self._early):
            self._drone.session.withdraw_start('cancel')
            return CancelResponse.ACCEPT
        is_replacing = self._replacing is not None and goal is self._replacing[0]
        if goal not in self._flying and not is_replacing:
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
            elif goal in self._flying:
                self._flying.remove(goal)
                remaining = self._drone.remaining()
                shots = self._shots(remaining.visited)
                self._end(goal, cancelled_message(remaining, shots, error))

    def _feedback(self) -> FlyRoute.Feedback:
        left = self._drone.remaining()
        return FlyRoute.Feedback(
            viewpoint_index=left.visited,
            viewpoint_count=left.count,
            distance_left_m=left.distance_m,
            time_left_s=left.time_s,
        )


def _require_confirmed(request: FlyRoute.Goal) -> None:
    """Refuse a take-off without a confirmation of exactly this route.

    Raises
    ------
    CommandRefusedError
        Naming what the goal must carry.
    """
    wanted = route_digest(request.plan_id, request.route)
    if request.confirmation != wanted:
        raise CommandRefusedError(
            f'the take-off of a real vehicle must be confirmed: send this goal with '
            f'confirmation {wanted}'
        )


def _key(request: FlyRoute.Goal) -> str:
    """Return what tells a route of a mission from all others."""
    return f'{request.lease} {route_digest(request.plan_id, request.route)}'


def _is_same(one: FlyRoute.Goal, other: FlyRoute.Goal) -> bool:
    """Return whether two goals ask for the same flight."""
    return bool(one.plan_id == other.plan_id and one.route == other.route)
