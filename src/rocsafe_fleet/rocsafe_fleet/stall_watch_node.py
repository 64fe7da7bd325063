# SPDX-License-Identifier: Apache-2.0
"""The watch that lets simulated time go on without a process that holds it up."""

import time
from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from rocsafe_fleet.options import AgentOptions
from rocsafe_interfaces.msg import StepDone
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_ros.process.run import is_orphan


class StallWatch:
    """Lets simulated time not wait for a participant whose process is gone.

    Parameters
    ----------
    node
        Publishes that a participant has left, and hears which steps are done once time stalls.
    options
        Names of participants, and how long time may stand still.
    on_left
        Called with the name of each participant without which time goes on.

    Attributes
    ----------
    step_s
        Steady time of the last step.
    """

    def __init__(self, node: Node, options: AgentOptions, on_left: Callable[[str], None]) -> None:
        self._node, self._options, self._on_left = node, options, on_left
        self._done = topics.create_publisher(node, topics.STEP_DONE)
        self._steps: dict[str, int] = {}
        self._subscription: Any = None
        self.step_s = time.monotonic()

    def note_step(self) -> None:
        """Note that time went on."""
        self.step_s = time.monotonic()

    def look(self) -> None:
        """Go on without those that have not done the newest step."""
        limit_s = self._options.alone_after_s if is_orphan() else self._options.lost_after_s
        stalled_s = time.monotonic() - self.step_s
        if stalled_s < 0.5 * limit_s:
            if self._subscription is not None:
                self._node.destroy_subscription(self._subscription)
                self._subscription = None
                self._steps.clear()
        elif self._subscription is None:
            done = topics.STEP_DONE
            self._subscription = topics.create_subscription(self._node, done, self._on_done)
        elif stalled_s > limit_s and self._steps:
            newest = max(self._steps.values())
            for name in (*self._options.participants, *self._options.others):
                if self._steps.get(name, -1) < newest:
                    self._done.publish(StepDone(participant=name, has_left=True))
                    self._on_left(name)

    def _on_done(self, message: StepDone) -> None:
        self._steps[message.participant] = ns_of_stamp(message.step)
