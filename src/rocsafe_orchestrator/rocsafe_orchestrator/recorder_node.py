# SPDX-License-Identifier: Apache-2.0
"""Node that records the topics of a run: as MCAP segments, and in its evidence log."""

import json
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.serialization import deserialize_message
from rclpy.subscription import Subscription

from rocsafe_geo.evidence.evidence_log import LOG_NAME, Event
from rocsafe_geo.option import option
from rocsafe_orchestrator.recording.evidence_events import KEPT, EvidenceEvents
from rocsafe_orchestrator.recording.evidence_writer import EvidenceWriter, hashes_told
from rocsafe_orchestrator.recording.message_definitions import MessageDefinitions
from rocsafe_orchestrator.recording.recorded_topics import (
    AWAITED_TOPICS,
    channel_of,
    recorded_topics,
)
from rocsafe_orchestrator.recording.segments import SegmentWriter
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.interface_spec import TopicSpec, name_of
from rocsafe_ros.lockstep import Participant
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.process.run import run

# Periods of wall time: checks for publishers, and flushes outside lock-step.
POLL_S = 0.05
FLUSH_S = 0.2
# Wall time after which the recorder takes part without all vehicles.
JOIN_DEADLINE_S = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RecorderOptions:
    """Parameters of the recorder."""

    output_directory: str = option('.', 'run directory; segments mission.part-N.mcap go there')
    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles to record')
    other_cameras: tuple[str, ...] = option((), 'names of further cameras of the vehicles')
    real_vehicles: tuple[str, ...] = option((), 'those of `vehicles` that are no simulation')
    lock_step: bool = option(True, 'take part in lock-step simulation as "recorder"')

    def __post_init__(self) -> None:
        """Refuse vehicles that would be recorded twice."""
        if len(set(self.vehicles)) != len(self.vehicles):
            raise ValueError(f'vehicles {list(self.vehicles)} must differ from each other')


class RecorderNode(Node):
    """Writes raw messages of the topics in `recorded_topics`, and the evidence log.

    In lock-step it reports a step as done when all earlier messages are flushed. A restarted
    recorder takes part again only when all vehicles are connected, or after a deadline, so that
    simulated time waits for it.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('recorder', **node_options)
        self._options = declare_options(self, RecorderOptions)
        self._segment = SegmentWriter(
            Path(self._options.output_directory), MessageDefinitions.of_environment()
        )
        self._begin_evidence(RunDirectory(Path(self._options.output_directory)))
        self._now_ns = 0
        self._early: list[tuple[int, bytes]] = []
        self._awaited = self._subscribe()
        self._participant: Participant | None = None
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        if self._options.lock_step:
            self._polls_left = JOIN_DEADLINE_S // POLL_S
            self._timer = self.create_timer(POLL_S, self._join, clock=steady)
        # In lock-step each step flushes too, but time may stand still.
        self.create_timer(FLUSH_S, self._segment.flush, clock=steady)
        self.get_logger().info(f'recording to {self._segment.path}')

    def destroy_node(self) -> None:
        """Finish and close segment and log."""
        self._write_early()
        self._segment.close()
        self._log.add(self._events.rest())
        self._log.close()
        super().destroy_node()

    def _subscribe(self) -> list[Subscription]:
        """Subscribe to all topics; return the subscriptions with a permanent publisher."""
        awaited = []
        options = self._options
        for spec, vehicle in recorded_topics(
            options.vehicles, options.other_cameras, options.real_vehicles
        ):
            # Under the name that everybody knows, also if the mission has one of its own.
            full_name = self.resolve_topic_name(name_of(spec, vehicle), only_expand=True)
            number = self._segment.add_channel(channel_of(spec, full_name))
            subscription = topics.create_subscription(
                self, spec, self._callback(number, spec, vehicle), vehicle, is_recording=True
            )
            if spec in AWAITED_TOPICS:
                awaited.append(subscription)
        return awaited

    def _begin_evidence(self, run: RunDirectory) -> None:
        """Open the log; its first entry is where the run comes from."""
        path = run.path / LOG_NAME
        self._log = EvidenceWriter(path, self.get_logger().error)
        self._events = EvidenceEvents(time.time, hashes_told(path))
        if run.run_info.is_file():
            what = json.loads(run.run_info.read_text(encoding='utf-8'))
            self._log.add([Event(time_s=time.time(), kind='run', by='recorder', what=what)])

    def _callback(self, number: int, spec: TopicSpec, vehicle: str) -> Callable[[bytes], None]:
        """Return what is done with each message of a topic."""
        record = partial(self._on_message, number)
        if spec.name not in KEPT:
            return record

        def on_message(data: bytes) -> None:
            record(data)
            message = deserialize_message(data, spec.message_type)
            self._log.add(self._events.of(spec, vehicle, message, data))

        return on_message

    def _on_message(self, number: int, data: bytes) -> None:
        if not self._options.lock_step:
            self._segment.write(number, data, self.get_clock().now().nanoseconds)
        elif self._now_ns:
            self._segment.write(number, data, self._now_ns)
        else:
            # Latched messages may arrive before the first clock message.
            self._early.append((number, data))

    def _on_step(self, time_ns: int) -> bool:
        self._now_ns = time_ns
        self._write_early()
        self._segment.flush()
        return True

    def _join(self) -> None:
        self._polls_left -= 1
        unheard = [s.topic_name for s in self._awaited if not s.get_publisher_count()]
        if unheard and self._polls_left > 0:
            return
        if unheard:
            self.get_logger().warning(f'recording without {", ".join(unheard)}: not published')
        self._timer.cancel()
        self._participant = Participant(self, 'recorder', self._on_step)

    def _write_early(self) -> None:
        for number, data in self._early:
            self._segment.write(number, data, self._now_ns)
        self._early.clear()


def main() -> int:
    """Run the recorder."""
    return run(RecorderNode)


if __name__ == '__main__':
    sys.exit(main())
