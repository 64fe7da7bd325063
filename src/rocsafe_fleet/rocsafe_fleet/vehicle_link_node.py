# SPDX-License-Identifier: Apache-2.0
"""What an agent hears from its vehicle, and how it lets it fly: topics and actions, by lease."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.action import ActionClient
from rclpy.node import Node
from std_srvs.srv import Trigger

from rocsafe_fleet.conversions import inability, is_aloft, numbers_of, visited_of
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import Control, Route, VehicleState
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import name_of
from rocsafe_ros.lease.holder_node import Leases
from rocsafe_ros.plan_digest import route_digest

# A route is sent again if it is not accepted within this time, so often.
REPEAT_S = 2.0
MOST_TRIES = 5
# A vehicle in the air that sends nothing for this time is lost, seconds.
SILENT_S = 10.0


class VehicleLink:
    """One vehicle of an agent.

    Parameters
    ----------
    node
        Node that owns the subscriptions and clients.
    leases
        Of the vehicles of the node.
    mission
        Name of the mission.
    now_s
        Returns the time by which its silence is measured, seconds.
    is_real
        Whether it is no simulation.

    Attributes
    ----------
    state
        Newest state; None: nothing was heard yet.
    routes
        Viewpoints of all routes that it may be flying, by plan id.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        leases: Leases,
        mission: str,
        now_s: Callable[[], float],
        *,
        is_real: bool,
    ) -> None:
        self.name = name
        self.state: VehicleState | None = None
        self._now_s, self._heard_s = now_s, now_s()
        self._left_s: float | None = None
        self._is_real = is_real
        self._mission = mission
        self._leases = leases
        self._log = node.get_logger()
        self._control: Control | None = None
        self.routes: dict[str, tuple[int, ...]] = {}
        self._sending: tuple[Callable[[], None], float, int] | None = None
        self._landing: tuple[str, Route] | None = None
        self._rejections = 0
        self._newest = self._refusal = ''
        topics.create_subscription(node, topics.STATE, self._on_state, name)
        topics.create_subscription(node, topics.CONTROL, self._on_control, name)
        self._flights = ActionClient(node, FlyRoute, name_of(calls.FLY_ROUTE, name))
        self._home = node.create_client(Trigger, name_of(calls.RETURN_HOME, name))

    def close(self) -> None:
        """Destroy the client of the action, which keeps its node in the graph."""
        self._flights.destroy()

    @property
    def is_busy(self) -> bool:
        """Whether an order was not carried out yet."""
        return self._sending is not None

    @property
    def is_down(self) -> bool:
        """Whether it is not in the air, as far as it is heard."""
        return self.state is None or not is_aloft(self.state)

    def is_silent(self, now_s: float) -> bool:
        """Return whether it was in the air and has told nothing for too long.

        Also whether it was left out, and was not heard since.
        """
        if self._left_s is not None and self._left_s >= self._heard_s:
            return True
        if self.state is None or self.is_down:
            return False
        return now_s - self._heard_s > SILENT_S

    def leave_out(self) -> None:
        """Take it for silent until it is heard again: simulated time goes on without it."""
        self._left_s = self._now_s()

    @property
    def inability(self) -> str:
        """Why it takes no more work; empty: it does."""
        if self.state is None or self._refusal:
            return self._refusal
        return inability(self.state, self._control, self._mission, self._is_real)

    @property
    def visited(self) -> tuple[int, ...]:
        """Viewpoints whose photographs it has handed over on its present route."""
        if self.state is None:
            return ()
        return visited_of(self.state, self.routes.get(self.state.plan_id, ()))

    def fly(self, plan_id: str, route: Route | None) -> None:
        """Let it fly a route in place of its present one; without one it returns home.

        A vehicle that lands takes no orders: it is given the route when it has landed.
        """
        self._landing, self._rejections = None, 0
        self._newest = plan_id
        is_landing = self.state is not None and self.state.state == VehicleState.LANDING
        if route is None:
            if not self.is_down and not is_landing:
                self._begin(self._return)
            return
        self.routes[plan_id] = numbers_of(route)
        if is_landing and self._is_real:
            self._refuse_all('it lands, and a real vehicle takes off again by hand only')
        elif is_landing:
            self._landing = plan_id, route
        else:
            self._begin(partial(self._send, plan_id, route))

    def fly_again(self) -> None:
        """Send the route that it did not take while it landed, once it stands."""
        if self._landing is not None and self.is_down:
            order, self._landing = self._landing, None
            self._begin(partial(self._send, *order))

    def look(self) -> None:
        """Repeat an order that was not answered; give it up after some tries."""
        if self._sending is None:
            return
        send, due_s, tries = self._sending
        if time.monotonic() < due_s:
            return
        if tries >= MOST_TRIES:
            self._refuse_all(f'did not take its route within {tries} tries')
            self._sending = None
            return
        self._sending = send, time.monotonic() + REPEAT_S, tries + 1
        send()

    def _begin(self, send: Callable[[], None]) -> None:
        self._sending = send, time.monotonic() + REPEAT_S, 1
        send()

    def _send(self, plan_id: str, route: Route) -> None:
        def send(lease: str) -> None:
            goal = FlyRoute.Goal(route=route, plan_id=plan_id, replace=True, lease=lease)
            goal.confirmation = route_digest(plan_id, route)
            answered = partial(self._on_goal, plan_id, route)
            self._flights.send_goal_async(goal).add_done_callback(answered)

        self._leases.carry(self.name, send, self._refuse)

    def _return(self) -> None:
        self._home.call_async(Trigger.Request()).add_done_callback(self._on_return)

    def _on_goal(self, plan_id: str, route: Route, future: Any) -> None:
        handle = future.result()
        if handle is not None and handle.accepted:
            self._sending = None
            handle.get_result_async().add_done_callback(partial(self._on_result, plan_id, route))

    def _on_result(self, plan_id: str, route: Route, future: Any) -> None:
        result = future.result().result
        if result.outcome != FlyRoute.Result.REJECTED:
            return
        self._log.warning(f'{self.name}: {result.error_msg}')
        if plan_id != self._newest:
            return
        self._rejections += 1
        if self._rejections > MOST_TRIES:
            self._refuse_all(f'refuses its route: {result.error_msg}')
        else:
            self._landing = plan_id, route

    def _refuse_all(self, why: str) -> None:
        """Note that it takes no more work: others fly its route."""
        self._log.error(f'{self.name}: {why}')
        self._refusal = why

    def _on_return(self, future: Any) -> None:
        self._sending = None
        if not future.result().success:
            self._log.warning(future.result().message)

    def _refuse(self, text: str) -> None:
        self._log.warning(text)

    def _on_state(self, message: VehicleState) -> None:
        self.state, self._heard_s = message, self._now_s()

    def _on_control(self, message: Control) -> None:
        self._control = message
