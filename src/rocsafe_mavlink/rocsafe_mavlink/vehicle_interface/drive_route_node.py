# SPDX-License-Identifier: Apache-2.0
"""The action drive_route of a real ground vehicle."""

from typing import Any

from rclpy.action import ActionServer, CancelResponse

from rocsafe_interfaces.action import DriveRoute
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.errors import CommandRefusedError, WaitError
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.vehicle_interface.drive_conversions import (
    drive_assignment,
    drive_refusal,
    drive_result,
)
from rocsafe_mavlink.vehicle_interface.node_timing import TIMING
from rocsafe_ros import calls
from rocsafe_ros.conversions import point_of_position
from rocsafe_ros.lease.control_lease import LeaseRefusedError
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_ros.vehicle_scope import VehicleScopeNode


class DriveRouteServer:
    """Serves drive_route: one drive at a time, or another in its place if the goal asks so.

    A goal is executed, as rclpy calls it, when its result is known.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    drone
        The vehicle.
    lease
        Judges who may send goals.
    """

    def __init__(self, node: VehicleScopeNode, drone: Drone, lease: LeaseServer) -> None:
        self._drone, self._lease = drone, lease
        self._now_s = self._feedback_s = 0.0
        self._early: list[tuple[Any, float | None, int]] = []
        self._driving: Any = None
        self._replacing: tuple[Any, Assignment, int] | None = None
        self._cancelling: int | None = None
        self._results: dict[bytes, DriveRoute.Result] = {}
        self._server = ActionServer(
            node,
            calls.DRIVE_ROUTE.call_type,
            calls.DRIVE_ROUTE.name,
            execute_callback=self._result,
            handle_accepted_callback=self._on_goal,
            cancel_callback=self._on_cancel,
        )

    def step(self, now_s: float, *, is_supervised: bool = True) -> None:
        """Begin drives, give feedback, and end the goal of a drive that has ended."""
        del is_supervised  # nothing begins later than it was asked for
        self._now_s = now_s
        early, self._early = self._early, []
        for goal, since_s, withdrawals in early:
            if withdrawals != self._drone.session.withdrawals:
                self._refuse(goal, f'its start was withdrawn: {self._drone.session.withdrawn_by}')
            else:
                self._begin(goal, now_s if since_s is None else since_s)
        self._watch_replacement()
        self._watch_cancelling()
        summary = self._drone.summary()
        if self._driving is None:
            return
        if summary is not None:
            self._finish(drive_result(summary, self._driving.request.route))
        elif now_s - self._feedback_s >= TIMING.feedback_s:
            self._feedback_s = now_s
            self._driving.publish_feedback(self._feedback())

    def _on_goal(self, goal: Any) -> None:
        if not self._lease.is_for_another(goal.request.lease):
            # Its wait counts from the first step that looks at it.
            self._early.append((goal, None, self._drone.session.withdrawals))

    def _begin(self, goal: Any, since_s: float) -> None:
        """Begin the drive, or say why not; a goal that cannot be judged yet waits."""
        request, drone = goal.request, self._drone
        if request.route.vehicle not in ('', drone.spec.name):
            self._refuse(goal, f'the route is for {request.route.vehicle}')
            return
        try:
            self._lease.require(request.lease)
            assignment = drive_assignment(request.route, drone.spec)
            if request.replace and drone.flies_another(assignment):
                drone.replace_route(assignment, self._now_s)
                self._replacing = (goal, assignment, drone.commands.count)
                return
            drone.fly(assignment, self._now_s)
        except WaitError as reason:
            if self._now_s - since_s > TIMING.goal_wait_s:
                self._refuse(goal, str(reason))
            else:
                self._early.append((goal, since_s, drone.session.withdrawals))
            return
        except (LeaseRefusedError, CommandRefusedError, ValueError) as error:
            self._refuse(goal, str(error))
            return
        if self._driving is not None:
            self._finish(self._aborted('the same drive was sent again'))
        self._driving = goal

    def _watch_replacement(self) -> None:
        """Switch to the new drive when it is driven, or say why it is not."""
        if self._replacing is None:
            return
        goal, assignment, number = self._replacing
        error = self._drone.commands.outcome(number)
        if error is None:
            return
        self._replacing = None
        if error:
            self._refuse(goal, error)
            return
        if self._driving is not None:
            self._finish(self._aborted(f'{assignment.plan_id} is driven in its place'))
        self._drone.switch_to(assignment)
        self._driving = goal

    def _on_cancel(self, goal: Any) -> CancelResponse:
        """Hold; the goal ends when the vehicle holds, or has refused to."""
        if any(goal is one for one, _since_s, _withdrawals in self._early):
            self._drone.session.withdraw_start('cancel')
            return CancelResponse.ACCEPT
        is_replacing = self._replacing is not None and goal is self._replacing[0]
        if goal is not self._driving and not is_replacing:
            return CancelResponse.REJECT
        try:
            self._drone.commands.hold(self._now_s)
        except CommandRefusedError:
            return CancelResponse.REJECT
        if not is_replacing:
            self._cancelling = self._drone.commands.count
        return CancelResponse.ACCEPT

    def _watch_cancelling(self) -> None:
        if self._cancelling is None:
            return
        error = self._drone.commands.outcome(self._cancelling)
        if error is None:
            return
        self._cancelling = None
        if self._driving is not None:
            result = self._aborted(error or 'cancelled by request: the vehicle holds')
            result.outcome = DriveRoute.Result.ABORTED if error else DriveRoute.Result.CANCELLED
            self._finish(result)

    def _aborted(self, text: str) -> DriveRoute.Result:
        route = self._driving.request.route
        evidence = [stop.evidence for stop in route.stops[1:] if stop.evidence]
        return DriveRoute.Result(
            outcome=DriveRoute.Result.ABORTED,
            error_msg=text,
            evidence_taken=evidence[: self._drone.remaining().visited],
        )

    def _refuse(self, goal: Any, reason: str) -> None:
        self._end(goal, drive_refusal(f'{self._drone.spec.name}: {reason}'))

    def _finish(self, result: DriveRoute.Result) -> None:
        goal, self._driving = self._driving, None
        self._end(goal, result)

    def _end(self, goal: Any, result: DriveRoute.Result) -> None:
        motion = self._drone.vehicle.motion
        if motion is not None:
            result.position = point_of_position(motion.position)
        self._results[bytes(goal.goal_id.uuid)] = result
        goal.execute()

    def _result(self, goal: Any) -> DriveRoute.Result:
        result = self._results.pop(bytes(goal.goal_id.uuid))
        if goal.is_cancel_requested:
            goal.canceled()
        elif result.outcome == DriveRoute.Result.COMPLETED:
            goal.succeed()
        else:
            goal.abort()
        return result

    def _feedback(self) -> DriveRoute.Feedback:
        left = self._drone.remaining()
        return DriveRoute.Feedback(
            stop_index=left.visited,
            stop_count=left.count,
            distance_left_m=left.distance_m,
            time_left_s=left.time_s,
        )
