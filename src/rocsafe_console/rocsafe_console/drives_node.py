# SPDX-License-Identifier: Apache-2.0
"""Drives of ground vehicles: planned when an operator asks, driven when he has confirmed."""

from collections import OrderedDict
from collections.abc import Callable
from typing import Any

from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from rocsafe_console.drive_conversions import drive_of, plan_goal
from rocsafe_console.orders.order_book import Order
from rocsafe_console.picture.vehicle import Vehicle
from rocsafe_interfaces.action import DriveRoute, PlanGroundRoute
from rocsafe_interfaces.msg import GroundRoute
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.interface_spec import name_of

MOST_OFFERS = 50

Offer = Callable[[dict[str, Any] | None, str], None]
Note = Callable[[bool, str], None]


class Drives:
    """Asks the router of a mission for drives, and sends them to ground vehicles.

    All methods belong to the thread of the node that owns it. Answers have a node and an executor
    of their own: the events executor of rclpy 7.1 ends the process when a second server of an
    action answers too.

    Parameters
    ----------
    node
        Node of the console.
    """

    def __init__(self, node: Node) -> None:
        self._node = Node(
            f'{node.get_name()}_drives',
            context=node.context,
            use_global_arguments=False,
            start_parameter_services=False,
            enable_rosout=False,
        )
        self._executor = SingleThreadedExecutor(context=node.context)
        self._executor.add_node(self._node)
        self._open = 0
        self._router = ActionClient(self._node, PlanGroundRoute, calls.PLAN_GROUND_ROUTE.name)
        self._vehicles: dict[str, ActionClient] = {}
        self._offers: OrderedDict[str, GroundRoute] = OrderedDict()

    def add(self, vehicle: str) -> None:
        """Make the client of a ground vehicle."""
        name = name_of(calls.DRIVE_ROUTE, vehicle)
        self._vehicles[vehicle] = ActionClient(self._node, DriveRoute, name)

    def look(self) -> None:
        """Take what was answered; called often."""
        if self._open:
            self._executor.spin_once(timeout_sec=0.0)

    def close(self) -> None:
        """Destroy the clients and their node."""
        self._executor.shutdown()
        for client in (self._router, *self._vehicles.values()):
            client.destroy()
        self._node.destroy_node()

    def plan(self, order: Order, vehicle: Vehicle, offer: Offer) -> None:
        """Plan the drive of an order; `offer` gets it, or None and the reason."""
        if not self._router.server_is_ready():
            offer(None, 'no router is there: the mission has no ground vehicle, or is over')
            return

        def on_result(future: Any) -> None:
            result = future.result().result
            if result.error_code != result.NONE:
                offer(None, f'router: {result.error_msg}')
                return
            self._offers[order.request_id] = result.route
            while len(self._offers) > MOST_OFFERS:
                self._offers.popitem(last=False)
            offer(drive_of(result.route), '')

        self._send(
            self._router, plan_goal(order, vehicle), on_result, lambda text: offer(None, text)
        )

    def drive(self, order: Order, name: str, lease: str, note: Note) -> None:
        """Send the drive that was offered for an order; `note` gets whether it is driven."""
        route = self._offers.pop(order.request_id, None)
        client = self._vehicles.get(name)
        if route is None or client is None or not client.server_is_ready():
            note(False, f'{name}: cannot be reached')
            return

        def on_result(future: Any) -> None:
            result = future.result().result
            note(result.outcome != result.REJECTED, result.error_msg)

        goal = DriveRoute.Goal(route=route, lease=lease, replace=True)
        self._send(
            client, goal, on_result, lambda text: note(False, f'{name}: {text}'),
            lambda _feedback: note(True, ''),
        )  # fmt: skip

    def _send(
        self,
        client: ActionClient,
        goal: Any,
        on_result: Callable[[Any], None],
        refuse: Callable[[str], None],
        on_feedback: Callable[[Any], None] | None = None,
    ) -> None:
        self._open += 1

        def on_end(future: Any) -> None:
            self._open -= 1
            on_result(future)

        def on_goal(future: Any) -> None:
            handle = future.result()
            if handle is None or not handle.accepted:
                self._open -= 1
                refuse('the request was not accepted')
                return
            handle.get_result_async().add_done_callback(on_end)

        client.send_goal_async(goal, feedback_callback=on_feedback).add_done_callback(on_goal)
