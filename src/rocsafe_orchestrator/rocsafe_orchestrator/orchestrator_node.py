# SPDX-License-Identifier: Apache-2.0
"""The orchestrator's ROS side: requests to the nodes, and their messages."""

import dataclasses
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental.events_executor import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from rocsafe_geo.frame import LocalFrame
from rocsafe_interfaces.msg import (
    AgentState,
    DoseAlarm,
    HazardSourceArray,
    RadiationReading,
    ReleaseEstimateArray,
    ShotReceipt,
    StepDone,
    VehicleState,
)
from rocsafe_orchestrator import conversions
from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.mission.drive_watch import Reading
from rocsafe_orchestrator.mission.options import Deadlines, OrchestratorOptions
from rocsafe_orchestrator.mission.status import Monitor, RunStatus
from rocsafe_orchestrator.mission_state.step_reports import StepReports
from rocsafe_orchestrator.parameters import goal_conversions
from rocsafe_orchestrator.process_table.table import Endpoint, ProcessSpec
from rocsafe_orchestrator.requests.requests_node import Requests
from rocsafe_orchestrator.watches.decisions import Decision
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.domain.mission_identity import MissionIdentity
from rocsafe_ros.frames import publish_origin
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.health import HealthReporter
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario

NAME = 'orchestrator'
# Requests are few, and their answers may wait so long.
ANSWER_PERIOD_S = 0.02
# Agents that have told nothing for so long are not waited for, seconds of wall time.
AGENT_SILENCE_S = 60.0


class OrchestratorNode(Node):
    """Receives the state of the nodes and publishes the state of the mission.

    Publishes ``region``, ``mission/state`` and ``decisions``. Service: ``mission/replan``.
    Subscribes ``<vehicle>/state``, ``<vehicle>/radiation``, ``<vehicle>/dose_alarm``,
    ``hazard/sources``, ``shots/receipts`` and, while time stands still, ``sim/step_done``.
    Its `requests` call the other nodes, from a lean node of their own, `requester`.
    """

    def __init__(
        self, scenario: Scenario, monitor: Monitor, identity: MissionIdentity, **node_options: Any
    ) -> None:
        rules = ['--ros-args', *identity.remapping_arguments]
        try:
            super().__init__(NAME, cli_args=rules, **node_options)
        except RuntimeError as error:  # no memory, no thread
            raise _no_ros(error) from error
        self.deadlines = Deadlines(**dataclasses.asdict(_options(self)))
        self._scenario = scenario
        self._monitor = monitor
        self._mission_id = identity.mission
        self._states: dict[str, VehicleState] = {}
        self.steps = StepReports()
        self._agents: dict[str, tuple[AgentState, float]] = {}
        self._steps_watch: Any = None
        self.requester = Node(
            f'{NAME}_requests',
            context=self.context,
            use_global_arguments=False,
            cli_args=rules,
            start_parameter_services=False,
            enable_rosout=False,
        )
        self.requests = Requests(self.requester, scenario, monitor, identity.mission)
        self.create_service(calls.REPLAN.call_type, calls.REPLAN.name, self._on_replan)
        self._wire()

    def _wire(self) -> None:
        names = self._scenario.all_names
        self._state = topics.create_publisher(self, topics.MISSION_STATE)
        self._region = topics.create_publisher(self, topics.REGION)
        self._decisions = topics.create_publisher(self, topics.DECISIONS)
        self._health = HealthReporter(self)
        for name in names:
            topics.create_subscription(self, topics.STATE, self._on_state, name)
            on_reading = partial(self._on_reading, name)
            topics.create_subscription(self, topics.RADIATION, on_reading, name)
            on_alarm = partial(self._on_alarm, name)
            topics.create_subscription(self, topics.DOSE_ALARM, on_alarm, name)
        topics.create_subscription(self, topics.HAZARD_SOURCES, self._on_sources)
        topics.create_subscription(self, topics.RELEASES, self._on_releases)
        topics.create_subscription(self, topics.RECEIPTS, self._on_receipt)
        if self._scenario.fleet.agents:
            topics.create_subscription(self, topics.AGENTS, self._on_agent)

    def destroy_node(self) -> None:
        """Destroy the node and the clients that it made."""
        self.requests.close()
        self.requester.destroy_node()
        super().destroy_node()

    def publish_region(self) -> None:
        """Publish what is surveyed, and where the map lies on the earth."""
        region = goal_conversions.region_of_scenario(self._scenario)
        region.header.stamp = self.get_clock().now().to_msg()
        region.header.frame_id = 'earth'
        self._region.publish(region)
        publish_origin(self, LocalFrame(self._scenario.origin_position()))

    def ready(self, table: Iterable[ProcessSpec]) -> frozenset[str]:
        """Return the names of the processes whose endpoints all exist."""
        return frozenset(
            spec.name
            for spec in table
            if all(self._exists(endpoint, spec) for endpoint in spec.readiness)
        )

    def _exists(self, endpoint: Endpoint, spec: ProcessSpec) -> bool:
        if endpoint.kind != 'topic':
            return self.requests.is_ready(endpoint)
        publishers = self.get_publishers_info_by_topic(f'/{endpoint.name.lstrip("/")}')
        # Everybody in lock-step publishes on one topic.
        is_shared = endpoint.spec is topics.STEP_DONE
        return any(not is_shared or found.node_name == spec.name for found in publishers)

    def publish(self, status: RunStatus) -> None:
        """Publish the state of the mission."""
        state = conversions.mission_state(status, self._mission_id, list(self._states.values()))
        state.header.stamp = self.get_clock().now().to_msg()
        self._state.publish(state)

    def tell(self, decision: Decision, wall_time_s: float) -> None:
        """Publish a decision that was taken `wall_time_s` seconds after the run began."""
        message = conversions.decision_message(decision, NAME, wall_time_s)
        message.header.stamp = self.get_clock().now().to_msg()
        self._decisions.publish(message)

    # Participants that hold up simulated time.

    def watch_steps(self, is_wanted: bool) -> None:
        """Listen to the steps that the participants report, or stop listening."""
        if is_wanted and self._steps_watch is None:
            self.steps.forget()
            self._steps_watch = topics.create_subscription(self, topics.STEP_DONE, self._on_step)
        elif not is_wanted and self._steps_watch is not None:
            self.destroy_subscription(self._steps_watch)
            self._steps_watch = None

    def waiting_for(self, participants: Iterable[str]) -> tuple[str, ...]:
        """Return the participants that are late for a step; none while nobody listens."""
        return () if self._steps_watch is None else self.steps.late(participants, time.monotonic())

    # What the nodes say.

    def _on_state(self, message: VehicleState) -> None:
        self._states[message.vehicle] = message
        self._monitor.on_vehicle(conversions.status_of_vehicle(message), time.monotonic())

    def _on_agent(self, message: AgentState) -> None:
        self._agents[message.vehicle] = message, time.monotonic()

    @property
    def agents_plan(self) -> bool:
        """Whether an agent that is heard plans."""
        heard_s = time.monotonic() - AGENT_SILENCE_S
        return any(m.is_planning and told_s >= heard_s for m, told_s in self._agents.values())

    @property
    def agents_are_done(self) -> bool:
        """Whether all agents that are heard have nothing left to fly.

        Agents of a host that is cut off are not waited for.
        """
        heard_s = time.monotonic() - AGENT_SILENCE_S
        return bool(self._agents) and all(
            message.is_done or told_s < heard_s for message, told_s in self._agents.values()
        )

    def _on_reading(self, vehicle: str, message: RadiationReading) -> None:
        position = conversions.position_of_reading(message)
        if position is None:
            return
        self._monitor.on_dose_rate(vehicle, message.dose_rate_usvh, position)
        drives = self.requests.drives
        if drives is not None and vehicle == self._scenario.driver_name:
            stamp, speed_mps = message.header.stamp, self._monitor.driver.speed_mps
            drives.on_reading(
                Reading(
                    stamp_s=stamp.sec + 1e-9 * stamp.nanosec, rate_usvh=message.dose_rate_usvh,
                    place=position, speed_mps=speed_mps,
                )
            )  # fmt: skip

    def _on_alarm(self, vehicle: str, message: DoseAlarm) -> None:
        # The ground vehicle has limits of its own.
        is_drone = vehicle != self._scenario.driver_name
        if message.triggered and message.turns_back and is_drone:
            self._monitor.on_turn_back(vehicle, conversions.turn_back_text(message))

    def _on_sources(self, message: HazardSourceArray) -> None:
        self._monitor.sources = conversions.sources_of(message)
        if self.requests.drives is not None:
            self.requests.drives.on_sources()

    def _on_releases(self, message: ReleaseEstimateArray) -> None:
        self._monitor.releases = conversions.releases_of(message)
        self._monitor.release_unit = message.rate_unit

    def _on_receipt(self, message: ShotReceipt) -> None:
        if message.status == ShotReceipt.REJECTED:
            self._monitor.on_rejected(message.shot_id, message.reason)
        else:
            self._monitor.on_stored(message.shot_id)

    def _on_replan(self, _request: Any, response: Any) -> Any:
        response.message = self.requests.replan()
        response.success = not response.message
        return response

    def _on_step(self, message: StepDone) -> None:
        if message.has_left:
            self.steps.left_out(message.participant, time.monotonic())
        else:
            self.steps.done(message.participant, ns_of_stamp(message.step), time.monotonic())


def _options(node: Node) -> OrchestratorOptions:
    """Return the parameters of the orchestrator.

    Raises
    ------
    ScenarioError
        Naming a parameter with a wrong value, or one that there is no more.
    """
    try:
        return declare_options(node, OrchestratorOptions)
    except ParameterError as error:
        raise ScenarioError(str(error)) from error


def _no_ros(error: Exception) -> SetupError:
    return SetupError(f'cannot start ROS: {str(error).strip().splitlines()[0]}')


@contextmanager
def ros_session(identity: MissionIdentity, config: Path | None = None) -> Iterator[None]:
    """Initialise ROS as a part of a mission, and shut it down at the end.

    Signals are left alone: a mission handles them itself.

    Parameters
    ----------
    identity
        The mission.
    config
        File with parameters of the nodes.

    Raises
    ------
    SetupError
        If ROS cannot start.
    """
    # Every mission of this suite's own world runs on simulated time.
    arguments = ['--ros-args', '-p', 'use_sim_time:=true', *identity.ros_arguments]
    if config is not None:
        arguments += ['--params-file', str(config)]
    try:
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
    except Exception as error:  # rclpy's own error classes are not public
        raise _no_ros(error) from error
    try:
        yield
    finally:
        rclpy.try_shutdown()


class Spinner:
    """Serves the orchestrator for a while, again and again.

    Answers have an executor of their own: the events executor of rclpy 7.1 ends the process when
    a second server of an action answers too, which somebody else's vehicle may do at any time.
    """

    def __init__(self, node: OrchestratorNode) -> None:
        self._node = node
        self._executor = EventsExecutor()
        self._executor.add_node(node)
        self._answers = SingleThreadedExecutor()
        self._answers.add_node(node.requester)

    def spin_for(self, duration_s: float) -> None:
        """Handle everything that comes within `duration_s`."""
        end = time.monotonic() + duration_s
        while (now := time.monotonic()) < end:
            # Each look costs as much as ten messages, so it is not taken after every message.
            self._answers.spin_once(timeout_sec=0.0)
            self._listen_until(min(end, now + ANSWER_PERIOD_S))

    def _listen_until(self, end: float) -> None:
        while (left := end - time.monotonic()) > 0.0:
            self._executor.spin_once(timeout_sec=left)

    def close(self) -> None:
        """Destroy the node."""
        self._executor.remove_node(self._node)
        # What it waits for it still holds: a client of an action that is destroyed meanwhile
        # damages the memory of the process.
        self._answers.shutdown()
        self._node.destroy_node()
