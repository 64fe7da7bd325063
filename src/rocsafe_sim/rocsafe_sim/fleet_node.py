# SPDX-License-Identifier: Apache-2.0
"""The node ``fleet``: many simulated vehicles in one process."""

from collections import deque
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_ros.conversions import diagnostic
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lockstep import Participant
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run
from rocsafe_scene.errors import ViewError
from rocsafe_sim.clock.cadence import floor_to
from rocsafe_sim.errors import SimError
from rocsafe_sim.options import FleetOptions
from rocsafe_sim.rav.assembly import make_rav
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.rav.shared_parts import make_shared
from rocsafe_sim.vehicle_node import VehicleInterface


class FleetNode(Node):
    """Simulates the vehicles of `fleet_file`, each with a small node in its own namespace.

    In lock-step it is one participant, ``fleet``, which is idle when all vehicles are.

    A step advances all vehicles at once, and then publishes one after the other: services are
    answered in between, and an order takes effect at the time of the step, as it does after it.
    What orders have left to be computed is computed in such turns, too.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('fleet', **node_options)
        options = declare_options(self, FleetOptions)
        self._period_ns = options.fix_period_ns
        self._participant: Participant | None = None
        ravs = _ravs(options)
        self.vehicle_nodes = [
            VehicleScopeNode(
                'rav',
                namespace=f'{self.get_namespace().rstrip("/")}/{rav.parts.name}',
                start_parameter_services=False,
                enable_rosout=False,
                use_global_arguments=False,
                **node_options,
            )
            for rav in ravs
        ]
        self._waiting: deque[Callable[[], None]] = deque()
        # Due at once, again and again: other callbacks have their turns between two of its own.
        self._turns = self.create_timer(
            0.0, self._take_turn, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self._turns.cancel()
        self._interfaces: list[VehicleInterface] = []
        for number, (node, rav) in enumerate(zip(self.vehicle_nodes, ravs, strict=True)):
            on_busy = partial(self._on_busy, number)
            self._interfaces.append(VehicleInterface(node, rav, options.fix_period_ns, on_busy))
        if options.lock_step:
            self._participant = Participant(
                self, self.get_name(), self._on_step, has_news=self._has_news
            )
        else:
            self.create_timer(1.0 / options.fix_rate_hz, self._on_timer)
            self._on_timer()

    def health(self) -> list[DiagnosticStatus]:
        """Return its own status and those of its vehicles."""
        vehicles = (interface.health() for interface in self._interfaces)
        return [diagnostic('runs'), *filter(None, vehicles)]

    def _on_step(self, time_ns: int) -> bool | None:
        # The step before may have something left to publish.
        self._take_all_turns()
        for interface in self._interfaces:
            interface.advance(time_ns)
        self._waiting.extend(interface.publish for interface in self._interfaces)
        if self.executor is None:
            self._take_all_turns()
            return self._is_idle
        self._turns.reset()
        return None

    def _take_turn(self) -> None:
        if self._waiting:
            self._waiting.popleft()()
        if not self._waiting:
            self._turns.cancel()
            if self._participant is not None:
                self._participant.finish(is_idle=self._is_idle)

    def _take_all_turns(self) -> None:
        while self._waiting:
            self._waiting.popleft()()

    @property
    def _is_idle(self) -> bool:
        return all(interface.is_idle for interface in self._interfaces)

    def _has_news(self) -> bool:
        return any(interface.has_news for interface in self._interfaces)

    def _on_busy(self, number: int) -> None:
        self._waiting.append(self._interfaces[number].look_ahead)
        self._turns.reset()
        if self._participant is not None:
            self._participant.report(is_idle=False)

    def _on_timer(self) -> None:
        self._on_step(floor_to(self.get_clock().now().nanoseconds, self._period_ns))


def _ravs(options: FleetOptions) -> list[Rav]:
    """Return the vehicles, which share their cameras' renderer."""
    spool = Path(options.spool_directory) if options.spool_directory else None
    try:
        shared = make_shared(options)
        return [
            make_rav(options, each.name, each.home_position, shared, spool and spool / each.name)
            for each in options.vehicles()
        ]
    except (SimError, ViewError, ValueError, OSError) as error:
        raise ParameterError(f'fleet: {error}') from error


def make_nodes() -> list[Node]:
    """Return the fleet's node and those of its vehicles."""
    fleet = FleetNode()
    return [fleet, *fleet.vehicle_nodes]


def main() -> int:
    """Run the nodes until asked to stop."""
    return run(make_nodes)


if __name__ == '__main__':
    raise SystemExit(main())
