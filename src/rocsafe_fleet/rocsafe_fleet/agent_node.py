# SPDX-License-Identifier: Apache-2.0
"""The node ``agents``: the agents of one or several vehicles, which agree with all others."""

import fcntl
import os
import re
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import IO, Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_fleet.conversions import (
    dose_reading_of_message,
    has_flown,
    place_of_state,
    route_of,
    state_of,
)
from rocsafe_fleet.dds_link_node import DdsLink
from rocsafe_fleet.errors import LinkError
from rocsafe_fleet.fleet_start import FleetStart, fleet_start, has_started, keep_plan
from rocsafe_fleet.ledger.records import FIRST_EPOCH
from rocsafe_fleet.link.fleet_link import FleetLink
from rocsafe_fleet.link.zenoh_link import ZenohLink
from rocsafe_fleet.options import AgentOptions
from rocsafe_fleet.stall_watch_node import StallWatch
from rocsafe_fleet.vehicle_link_node import VehicleLink
from rocsafe_interfaces.msg import RadiationReading, SurveyPlan
from rocsafe_planner.solver.precompile import load_kernels
from rocsafe_ros.background_job import BackgroundJob
from rocsafe_ros.interfaces import topics
from rocsafe_ros.lease.control_lease import MISSION_VARIABLE
from rocsafe_ros.lease.holder_node import Leases
from rocsafe_ros.lockstep import Participant
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import FLEET_LOCK_VARIABLE, is_orphan, run

NAME = 'agents'
STEP_S = 0.05
LOOK_S = 0.05
REPORT_S = 1.0
# If no orchestrator lives, the agents end this time after the last landing, seconds.
LINGER_S = 10.0
# They also end if all vehicles stand, or simulated time does, for this time, seconds.
IDLE_S = 300.0
_NS = 1e-9


class AgentsNode(Node):
    """The agents of some vehicles. They speak only the vehicles' own topics and actions.

    Publishes ``fleet/delta`` and ``fleet/agents``; subscribes ``plan``, ``fleet/delta``, and
    ``<vehicle>/state``, ``<vehicle>/control`` and ``<vehicle>/radiation``. Uses
    ``<vehicle>/fly_route``, ``<vehicle>/lease`` and ``<vehicle>/return_home``. No simulated time
    passes while they plan, and until vehicles have taken their routes.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__(NAME, **node_options)
        self._options = options = declare_options(self, AgentOptions)
        self._fleet: FleetStart | None = None
        self._job: tuple[BackgroundJob[Any, None], Callable[[Any], None]] | None = None
        self._flown = dict.fromkeys(options.vehicles, FIRST_EPOCH)
        self._missed: set[str] = set()
        self._kept: set[str] = set()
        self._report_s = self._active_s = self._aloft_s = time.monotonic()
        self._needed_s = 0.0
        self._plan_id = ''
        self._has_flown = False
        self._lock = _locked()
        self._link = self._linked(options)
        self._states = topics.create_publisher(self, topics.AGENTS)
        self._stall_watch = StallWatch(self, options, self._leave_out)
        leases = Leases(
            self, options.vehicles, options.mission, self._warn, role='agent', is_reserve=True
        )
        self._links = {
            name: VehicleLink(
                self,
                name,
                leases,
                options.mission,
                self._now_s,
                is_real=name in options.real_vehicles,
            )
            for name in options.vehicles
        }
        # While the other nodes start: the first loss need not wait for it.
        BackgroundJob(lambda _report: load_kernels(), 'loading', None)
        topics.create_subscription(self, topics.PLAN, self._on_plan)
        for name in options.vehicles:
            topics.create_subscription(
                self, topics.RADIATION, partial(self._on_reading, name), name
            )
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._participant: Participant | None = None
        if options.lock_step:
            # The agents of each host have a name of their own.
            self._participant = Participant(self, self.get_name(), self._on_step)
        else:
            self.create_timer(STEP_S, lambda: self._on_step(time.monotonic_ns()), clock=steady)
        self.create_timer(LOOK_S, self._look, clock=steady)
        if has_started(options.state_directory):
            # The planner, which told the plan, may be gone.
            self._begin()

    def destroy_node(self) -> None:
        """Destroy the node and the clients that it made."""
        for link in self._links.values():
            link.close()
        self._link.close()
        sent, received = self._link.bytes_sent, self._link.bytes_received
        self.get_logger().info(f'link: {sent} bytes sent, {received} bytes received')
        super().destroy_node()

    def _linked(self, options: AgentOptions) -> FleetLink:
        """Return the way of packets to the agents of other processes."""
        if options.link == 'dds':
            return DdsLink(self)
        fleet = re.sub('[^A-Za-z0-9_-]', '_', options.mission) or 'fleet'
        try:
            return ZenohLink(fleet, options.link_listen, options.link_peers)
        except LinkError as error:
            raise ParameterError(f'agents: {error}') from error

    @property
    def is_needed(self) -> bool:
        """Whether an orchestrator lives, or something is left to fly."""
        now_s = time.monotonic()
        if now_s < self._needed_s:
            return True
        self._needed_s = now_s + LOOK_S
        if not all(link.is_down for link in self._links.values()):
            self._aloft_s = now_s
        still_s = now_s - min(self._aloft_s, self._stall_watch.step_s)
        is_flying = self._has_flown and not self._is_done() and still_s < IDLE_S
        if is_flying or not is_orphan():
            self._active_s = now_s
        return now_s - self._active_s < (LINGER_S if self._has_flown else LOOK_S)

    def _warn(self, text: str) -> None:
        self.get_logger().warning(text)

    # What the agents hear.

    def _on_plan(self, message: SurveyPlan) -> None:
        self._plan_id = message.plan_id

    def _on_reading(self, name: str, message: RadiationReading) -> None:
        reading = dose_reading_of_message(message)
        if self._fleet is not None and reading is not None:
            self._fleet.add_reading(name, reading)

    def _begin(self, plan_id: str = '') -> None:
        """Begin with the plan of the survey; no id: with the plan of an earlier start."""
        token = os.environ.get(MISSION_VARIABLE, '')
        try:
            self._fleet = fleet_start(self._options, plan_id, token, self._now_s())
        except (ValueError, OSError) as error:
            self.get_logger().error(f'no agents: {error}')
            self._plan_id = ''
            return
        known = self._fleet.load()
        for name, link in self._links.items():
            link.routes[self._fleet.plan_id] = self._fleet.first_route(name)
            link.routes.update((k, tuple(route)) for k, route in known.get(name, {}).items())

    def _receive(self, fleet: FleetStart) -> None:
        for data in self._link.receive():
            fleet.local.receive(data, self._now_s())

    @property
    def _is_busy(self) -> bool:
        """Whether a plan, a round or an order is under way."""
        return self._job is not None or any(link.is_busy for link in self._links.values())

    def _on_step(self, time_ns: int) -> bool | None:
        """Let the agents think at one time; return whether they have nothing to do.

        None: the step is done when what is under way is.
        """
        self._stall_watch.note_step()
        if self._fleet is None:
            return True
        fleet = self._fleet
        self._receive(fleet)
        for name, link in self._links.items():
            self._tell_agent(fleet, name, link, time_ns * _NS)
            link.fly_again()
        for data in fleet.local.advance(time_ns * _NS):
            self._link.send(data)
        self._plan(fleet)
        return None if self._is_busy else self._is_done()

    def _tell_agent(self, fleet: FleetStart, name: str, link: VehicleLink, time_s: float) -> None:
        """Tell an agent what its vehicle does."""
        agent = fleet.agent(name)
        if link.state is None:
            return
        self._has_flown = self._has_flown or has_flown(link.state)
        place = place_of_state(link.state, fleet.endurance_s(name))
        if place is not None:
            agent.move(place)
        if link.is_down:
            fleet.add_reading(name, None)
        if link.visited:
            agent.visit(link.visited)
        if link.is_silent(time_s):
            agent.disable('its vehicle is silent')
            self._missed.add(name)
            return
        agent.disable(link.inability)
        if name in self._missed and agent.is_done and not link.inability:
            # It was heard again after the others had flown all: it holds, and gets no new route.
            self._missed.discard(name)
            link.fly(fleet.plan_id, None)

    # Plans and routes.

    def _plan(self, fleet: FleetStart) -> None:
        """Begin to plan the newest proposal, or to choose the places of a round."""
        if self._job is not None or not self._has_flown:
            return
        wanted, seeker = fleet.local.wanted, fleet.local.seeker
        if wanted is not None:
            self._work(fleet, partial(fleet.plan, wanted), partial(fleet.local.planned, wanted))
        elif seeker is not None:
            self._work(fleet, fleet.choosing(seeker), seeker.decide)

    def _work(
        self,
        fleet: FleetStart,
        work: Callable[[Callable[[None], bool]], Any],
        take: Callable[[Any], None],
    ) -> None:
        """Compute beside the event loop, while no simulated time passes."""
        self._job = BackgroundJob(work, 'planning', None), take
        self._tell(fleet)

    def _look(self) -> None:
        """Take plans that are ready, repeat orders, find vehicles that hold up time."""
        for link in self._links.values():
            link.look()
        if self._fleet is None:
            # On another host than the planner's the file comes later than the message.
            if self._plan_id and Path(self._options.plan_file).is_file():
                self._begin(self._plan_id)
            return
        if self._job is not None and self._job[0].is_done:
            (job, take), self._job = self._job, None
            take(job.result())
            self._fly(self._fleet)
            self._plan(self._fleet)
        if self._participant is not None and not self._is_busy:
            self._participant.finish(is_idle=self._is_done())
        if self._options.lock_step and self._has_flown and not self._is_busy:
            self._stall_watch.look()
        if time.monotonic() - self._report_s >= REPORT_S:
            self._report_s = time.monotonic()
            self._report(self._fleet)

    def _fly(self, fleet: FleetStart) -> None:
        for name, link in self._links.items():
            agent = fleet.agent(name)
            is_new = agent.epoch > self._flown[name] and agent.own in agent.proposal.names
            if is_new and agent.plan.source is not None:
                self._missed.discard(name)
                self._flown[name] = agent.epoch
                source = agent.plan.source
                self.get_logger().info(
                    f'{name}: epoch {agent.epoch[0]}, plan {source.plan_id}, '
                    f'{len(agent.route)} viewpoints, {len(agent.proposal.names)} vehicles'
                )
                link.fly(source.plan_id, route_of(source, name, agent.visited))
                if source.plan_id not in self._kept:
                    self._kept.add(source.plan_id)
                    BackgroundJob(partial(self._keep, source), 'keeping', None)

    def _keep(self, plan: Any, _report: Callable[[None], bool]) -> None:
        """Write a plan for the report; runs in a thread."""
        try:
            keep_plan(plan, Path(self._options.plan_file).parent)
        except ValueError as error:
            self.get_logger().error(str(error))

    def _leave_out(self, name: str) -> None:
        """Take a vehicle whose process is silent for lost."""
        self._warn(f'{name}: its process is silent, simulated time goes on without')
        if name in self._links:
            self._links[name].leave_out()

    # What the agents tell.

    def _is_done(self) -> bool:
        fleet, links = self._fleet, self._links.values()
        if fleet is None or self._is_busy:
            return fleet is None
        now_s = self._now_s()
        is_down = all(link.is_down or link.is_silent(now_s) for link in links)
        return is_down and fleet.is_done and not fleet.others_aloft

    def _report(self, fleet: FleetStart) -> None:
        try:
            fleet.save({name: link.routes for name, link in self._links.items()})
        except OSError as error:
            self.get_logger().error(f'what the agents know is not kept: {error}', once=True)
        self._tell(fleet)

    def _tell(self, fleet: FleetStart) -> None:
        """Publish what the agents know."""
        stamp = self.get_clock().now().to_msg()
        is_done, is_planning = self._is_done(), self._job is not None
        for name in self._links:
            agent = fleet.agent(name)
            sent = fleet.local.bytes_sent[agent.own]
            state = state_of(agent, fleet.names, sent, is_done=is_done, is_planning=is_planning)
            state.header.stamp = stamp
            self._states.publish(state)

    def _now_s(self) -> float:
        """Return simulated time in lock-step, else one that nobody sets and no host publishes."""
        if self._options.lock_step:
            return float(self.get_clock().now().nanoseconds) * _NS
        return time.monotonic()


def _locked() -> IO[bytes] | None:
    """Lock the file that lets the nodes of the mission go on without their supervisor."""
    path = os.environ.get(FLEET_LOCK_VARIABLE)
    if not path:
        return None
    try:
        Path(path).touch()
        # Locked as long as the process lives.
        file = Path(path).open('rb')  # noqa: SIM115
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise ParameterError(f'{path}: cannot be locked: {error.strerror}') from error
    return file


def main() -> int:
    """Run the agents until asked to stop, or nothing is left to fly without an orchestrator."""
    return run(AgentsNode, outlives=lambda node: node.is_needed)


if __name__ == '__main__':
    raise SystemExit(main())
