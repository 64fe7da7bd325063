# SPDX-License-Identifier: Apache-2.0
"""Node that replays the inputs of a recorded run."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock as ClockMessage
from std_srvs.srv import Trigger

from rocsafe_interfaces.msg import DoseRate, HazardSourceArray, ShotReceipt
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_orchestrator.replay.feed import Feed, Input, StoredShot
from rocsafe_orchestrator.replay.recorded_inputs import (
    RecordedInputs,
    record_of,
    sources_of,
    time_of,
)
from rocsafe_orchestrator.replay.shot_conversions import shot_message
from rocsafe_ros.conversions import stamp_of_ns
from rocsafe_ros.interfaces import calls, topics

TICK_S = 0.01
SERVE_S = 0.05


class ReplayNode(Node):
    """Publishes a recorded run: ``region``, each vehicle's ``radiation`` and ``camera/shot``.

    Publishes also ``/clock``, the time of what is replayed. Subscribes what tells that an input
    was taken in: ``dose_rate`` and ``shots/receipts``; and ``hazard/sources``.
    """

    def __init__(self, inputs: RecordedInputs, vehicles: tuple[str, ...]) -> None:
        super().__init__('replay')
        self.feed = Feed([*inputs.readings, *inputs.shots])
        self.rejected: dict[str, str] = {}
        self.sources: tuple[tuple[float, float, float], ...] = ()
        self._asked: Any = None
        self._inputs = inputs
        self._clock_out = topics.create_publisher(self, topics.CLOCK)
        self._region = topics.create_publisher(self, topics.REGION)
        self._readings: dict[str, Publisher] = {}
        self._shots: dict[str, Publisher] = {}
        for name in vehicles:
            self._readings[name] = topics.create_publisher(self, topics.RADIATION, name)
            self._shots[name] = topics.create_publisher(self, topics.SHOT, name)
            on_rate = partial(self._on_dose_rate, name)
            topics.create_subscription(self, topics.DOSE_RATE, on_rate, name)
        topics.create_subscription(self, topics.RECEIPTS, self._on_receipt)
        topics.create_subscription(self, topics.HAZARD_SOURCES, self._on_sources)
        self._asking = self.create_client(
            calls.SUGGEST_VIEWPOINTS.call_type, calls.SUGGEST_VIEWPOINTS.name
        )
        self._saving = self.create_client(calls.SAVE_MOSAIC.call_type, calls.SAVE_MOSAIC.name)
        if inputs.region is not None:
            self._region.publish(inputs.region)
        self.create_timer(TICK_S, self._on_tick, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def is_localized(self) -> bool:
        """Return whether the localizer answers, which it does when it used all readings."""
        if self._asked is not None and self._asked.done():
            answer, self._asked = self._asked.result(), None
            return bool(answer.status != SuggestViewpoints.Response.NOT_YET)
        if self._asked is None:
            self._asked = self._asking.call_async(SuggestViewpoints.Request(count=0))
        return False

    def save(self) -> Any:
        """Ask for the map and return the future of the answer."""
        return self._saving.call_async(Trigger.Request())

    def _on_tick(self) -> None:
        newest_ns = 0
        for given in self.feed.due(time.monotonic()):
            self._publish(given)
            newest_ns = max(newest_ns, given.time_ns)
        if newest_ns:
            self._clock_out.publish(ClockMessage(clock=stamp_of_ns(newest_ns)))

    def _publish(self, given: Input) -> None:
        if not isinstance(given, StoredShot):
            self._readings[given.vehicle].publish(given.data)
            return
        photograph = self._inputs.photographs[given.shot_id]
        try:
            message = shot_message(record_of(photograph), photograph.path.read_bytes())
        except (OSError, ValueError) as error:
            self.rejected[given.shot_id] = str(error)
            self.feed.on_receipt(given.shot_id)
            return
        self._shots[given.vehicle].publish(message)

    def _on_dose_rate(self, vehicle: str, rate: DoseRate) -> None:
        self.feed.on_dose_rate(vehicle, time_of(rate))

    def _on_receipt(self, receipt: ShotReceipt) -> None:
        if receipt.status == ShotReceipt.REJECTED:
            self.rejected[receipt.shot_id] = receipt.reason
        self.feed.on_receipt(receipt.shot_id)

    def _on_sources(self, found: HazardSourceArray) -> None:
        self.sources = sources_of(found)


@contextmanager
def serving(node: ReplayNode) -> Iterator[Callable[[], None]]:
    """Give what serves the node for a moment, and destroy the node at the end."""
    executor = EventsExecutor()
    executor.add_node(node)
    try:
        yield partial(executor.spin_once, timeout_sec=SERVE_S)
    finally:
        executor.remove_node(node)
        node.destroy_node()
