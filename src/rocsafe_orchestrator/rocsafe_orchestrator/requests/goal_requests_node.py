# SPDX-License-Identifier: Apache-2.0
"""Goals of a mission to servers of actions, whose answers it gets."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient

from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission_state.request import Order

# Wall time after which a result that has not come is asked for again. A server sends it once: it
# is lost if the nodes did not know each other then, for instance after a computer has slept.
ASK_AGAIN_S = 20.0


@dataclass(slots=True, kw_only=True, eq=False)
class _OpenGoal:
    """A goal that was accepted and has no result yet."""

    order: Order
    on_result: Callable[..., None]
    handle: Any
    asked_s: float = 0.0


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
        self._open: list[_OpenGoal] = []

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
            goal = _OpenGoal(order=order, on_result=on_result, handle=handle)
            self._open.append(goal)
            self._ask(goal)

    def ask_again(self) -> None:
        """Ask again for the results that have not come for long."""
        late_s = time.monotonic() - ASK_AGAIN_S
        for goal in self._open:
            if goal.asked_s < late_s:
                self._ask(goal)

    def _ask(self, goal: _OpenGoal) -> None:
        goal.asked_s = time.monotonic()
        goal.handle.get_result_async().add_done_callback(partial(self._on_answer_to, goal))

    def _on_answer_to(self, goal: _OpenGoal, future: Any) -> None:
        """Report the result of a goal, which may come more than once."""
        if goal not in self._open:
            return
        self._open.remove(goal)
        # A server that was started again does not know the goals of the one before.
        if future.result().status != GoalStatus.STATUS_UNKNOWN:
            goal.on_result(goal.order, future)

    def _refuse(self, order: Order, text: str) -> None:
        if self._mission is not None:
            self._mission.refused(order, text)

    def _remark(self, text: str) -> None:
        if self._mission is not None:
            self._mission.remarks.append(text)
