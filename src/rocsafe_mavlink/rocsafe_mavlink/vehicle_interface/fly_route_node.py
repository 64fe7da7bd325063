# SPDX-License-Identifier: Apache-2.0
"""The action fly_route of a real vehicle."""

from collections.abc import Callable
from typing import Any

from rocsafe_interfaces.action import FlyRoute
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.flight_record import FlightSummary
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.flight.late_start import LateStart
from rocsafe_mavlink.vehicle_interface.conversions import assignment_of, delay_of
from rocsafe_mavlink.vehicle_interface.result_conversions import failure_message, result_message
from rocsafe_mavlink.vehicle_interface.route_goals_node import RouteGoals
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.control_lease import LeaseRefusedError
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_ros.plan_digest import route_digest


class FlyRouteServer(RouteGoals):
    """Serves fly_route; the parameters not named here are those of `RouteGoals`.

    A goal with a delay is begun so long after it came, on the ground or in the air. It is given up
    if the vehicle is told to hold, return or land meanwhile, if another route comes, or if nobody
    supervises the flight any more.

    Parameters
    ----------
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
        self._shots, self._late_start = shots, late_start
        self._late: tuple[list[Any], float] | None = None
        super().__init__(node, calls.FLY_ROUTE, drone, lease)

    def step(self, now_s: float, *, is_supervised: bool) -> None:
        """Begin the goals with a delay when they are due, or give them up; then as all goals."""
        if self._late is not None:
            goals, due_s = self._late
            if not self._drone.is_waiting:
                self._end_late(self.withdrawal())
            elif not is_supervised:
                self._end_late('nobody supervises the mission')
            elif now_s >= due_s:
                self._late = None
                self._drone.wait_until(None)
                for goal in goals:
                    self.keep(goal, now_s)
        super().step(now_s, is_supervised=is_supervised)

    def accept(self, goal: Any) -> None:
        """Let a goal begin at the next step, or when its delay is over."""
        request, now_s = goal.request, self.now_s()
        try:
            # A goal without the lease neither waits nor ends the wait of another.
            self._lease.require(request.lease)
            delay_s = delay_of(request.route)
        except (LeaseRefusedError, ValueError) as error:
            self.refuse(goal, str(error))
            return
        if self._late is not None and _is_same(self._late[0][0].request, request):
            self._late[0].append(goal)
            return
        self._end_late('another route came')
        if delay_s <= 0.0:
            self.keep(goal, now_s)
            return
        try:
            due_s = self._late_start.due_s(_key(request), now_s, delay_s)
        except OSError as error:
            self.refuse(goal, f'its delay cannot be kept over a restart: {error}')
            return
        self._late = ([goal], due_s)
        self._drone.wait_until(due_s)

    def is_early(self, goal: Any) -> bool:
        """Whether a goal was accepted and has not begun."""
        return (self._late is not None and goal in self._late[0]) or super().is_early(goal)

    def assignment(self, request: FlyRoute.Goal) -> Assignment:
        """Return the plan of the flight."""
        return assignment_of(request.route, request.plan_id, self._drone.spec)

    def start_refusal(self, request: FlyRoute.Goal) -> str:
        """Return why a goal may not take off: it must confirm exactly this route."""
        wanted = route_digest(request.plan_id, request.route)
        words = 'the take-off of a real vehicle must be confirmed: send this goal with'
        return '' if request.confirmation == wanted else f'{words} confirmation {wanted}'

    def result(self, _goal: Any, summary: FlightSummary) -> FlyRoute.Result:
        """Return the result of a flight that has ended."""
        return result_message(summary, self._shots(summary.visited))

    def failure(self, _goal: Any, text: str, outcome: str) -> FlyRoute.Result:
        """Return the result of a goal before the end of its flight."""
        if outcome == 'REJECTED':
            return failure_message(text, outcome, 0, 0)
        visited = self._drone.remaining().visited
        return failure_message(text, outcome, visited, self._shots(visited))

    def feedback(self) -> FlyRoute.Feedback:
        """Return how far the flight is."""
        left = self._drone.remaining()
        return FlyRoute.Feedback(
            viewpoint_index=left.visited,
            viewpoint_count=left.count,
            distance_left_m=left.distance_m,
            time_left_s=left.time_s,
        )

    def _end_late(self, why: str) -> None:
        """Give up the goals with a delay, if there are any."""
        if self._late is None:
            return
        (goals, _due_s), self._late = self._late, None
        self._late_start.forget()
        self._drone.wait_until(None)
        for goal in goals:
            self.refuse(goal, why)


def _key(request: FlyRoute.Goal) -> str:
    """Return what tells a route of a mission from all others."""
    return f'{request.lease} {route_digest(request.plan_id, request.route)}'


def _is_same(one: FlyRoute.Goal, other: FlyRoute.Goal) -> bool:
    """Return whether two goals ask for the same flight."""
    return bool(one.plan_id == other.plan_id and one.route == other.route)
