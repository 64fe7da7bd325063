# SPDX-License-Identifier: Apache-2.0
"""Goals of a mission to servers of actions, whose answers it gets."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.action import ActionClient

from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission_state.request import Order


class GoalRequests:
    """Sends goals, and reports to the mission whether they were accepted.

    Parameters
    ----------
    server
        Who is asked if an order names no vehicle.
    """

    def __init__(self, server: str) -> None:
        self._server = server
        self._mission: Mission | None = None

    def begin(self, mission: Mission) -> None:
        """Report answers to `mission` from now on."""
        self._mission = mission

    def _send_goal(
        self, client: ActionClient, goal: Any, order: Order, on_result: Callable[..., None]
    ) -> None:
        """Send a goal; its result goes to `on_result`, after the order."""
        sent = client.send_goal_async(goal)
        sent.add_done_callback(partial(self._on_goal, order, on_result))

    def _on_goal(self, order: Order, on_result: Callable[..., None], future: Any) -> None:
        handle = future.result()
        if self._mission is None or handle is None:
            return
        if not handle.accepted:
            self._refuse(order, f'{order.vehicle or self._server}: request was not accepted')
            return
        # A goal that is not accepted in time is sent again: of two that were accepted one answers.
        if self._mission.accepted(order):
            handle.get_result_async().add_done_callback(partial(on_result, order))

    def _refuse(self, order: Order, text: str) -> None:
        if self._mission is not None:
            self._mission.refused(order, text)

    def _remark(self, text: str) -> None:
        if self._mission is not None:
            self._mission.remarks.append(text)
