# SPDX-License-Identifier: Apache-2.0
"""The node ``rgv``: one simulated ground vehicle, named after its namespace."""

import time
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.clock import Clock, ClockType

from rocsafe_interfaces.msg import GasReading, RadiationReading
from rocsafe_ros.conversions import diagnostic, ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lockstep import Participant
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run
from rocsafe_scene.errors import ViewError
from rocsafe_sim.clock.cadence import floor_to
from rocsafe_sim.driving.readings import ReadingQueue
from rocsafe_sim.driving.rgv import Rgv
from rocsafe_sim.driving.rgv_options import RgvOptions
from rocsafe_sim.errors import SimError
from rocsafe_sim.messages.drive_conversions import ppm_of
from rocsafe_sim.vehicle_interface.rgv_interface_node import RgvInterface

# A detector that does not answer for this wall time is not waited for any longer.
LONGEST_WAIT_S = 20.0
LOOK_S = 0.5


class RgvNode(VehicleScopeNode):
    """Simulates the ground vehicle named by its namespace, see `RgvInterface`.

    In lock-step it is a participant with the name of the vehicle. While it drives, its step is
    done when the reading of its detector is there, so that its decisions do not depend on the
    speed of the machine. Otherwise it steps at its fix rate by its own clock.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('rgv', **node_options)
        options = declare_options(self, RgvOptions)
        if not self.vehicle_name:
            raise ParameterError('rgv: must stand in the namespace of a vehicle, e.g. __ns:=/rgv1')
        self._period_ns = options.fix_period_ns
        self._participant: Participant | None = None
        self._readings = ReadingQueue(options.reading_period_s)
        period_s = options.gas_period_s
        self._gases = {
            sensor: ReadingQueue(period_s, is_awaited=False) for sensor in options.gas_sensors
        }
        self._waits_since_s: float | None = None
        self._rgv = _rgv(options, self.vehicle_name)
        self._interface = RgvInterface(self, self._rgv, options.fix_period_ns, self._on_busy)
        topics.create_subscription(self, topics.RADIATION, self._on_reading)
        topics.create_subscription(self, topics.GAS, self._on_gas)
        if options.lock_step:
            self._participant = Participant(self, self.vehicle_name, self._on_step)
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            self.create_timer(LOOK_S, self._look, clock=steady)
        else:
            self.create_timer(1.0 / options.fix_rate_hz, self._on_timer)
            self._on_timer()

    def health(self) -> list[DiagnosticStatus]:
        """Return its own status and that of the vehicle."""
        return [diagnostic('runs'), *filter(None, [self._interface.health()])]

    def _on_step(self, time_ns: int) -> bool | None:
        self._step(time_ns)
        if self._rgv.rover.is_idle or self._has_all(time_ns):
            return self._rgv.rover.is_idle
        self._waits_since_s = time.monotonic()
        return None

    def _step(self, time_ns: int) -> None:
        if time_ns < self._rgv.rover.state.time_ns:
            self.get_logger().warning('time ran backwards: waiting until it is back', once=True)
            return
        for stamp_ns, rate_usvh in self._readings.due(self._rgv.rover.state.time_ns):
            self._rgv.rover.read(stamp_ns, rate_usvh)
        for sensor, queue in self._gases.items():
            for _, ppm in queue.due(self._rgv.rover.state.time_ns):
                self._rgv.rover.read_gas(sensor, ppm)
        self._interface.step(time_ns)

    def _on_reading(self, reading: RadiationReading) -> None:
        self._readings.add(ns_of_stamp(reading.header.stamp), reading.dose_rate_usvh)
        self._look_again()

    def _on_gas(self, reading: GasReading) -> None:
        queue = self._gases.get(reading.sensor)
        if queue is not None:
            queue.add(ns_of_stamp(reading.header.stamp), ppm_of(reading))
            self._look_again()

    def _has_all(self, time_ns: int) -> bool:
        return all(queue.has_all(time_ns) for queue in (self._readings, *self._gases.values()))

    def _look_again(self) -> None:
        if self._has_all(self._rgv.rover.state.time_ns):
            self._go_on()

    def _look(self) -> None:
        since = self._waits_since_s
        if since is not None and time.monotonic() - since > LONGEST_WAIT_S:
            self.get_logger().warning('no reading of its sensors: time goes on without')
            for queue in self._gases.values():
                queue.give_up()
            self._go_on()

    def _go_on(self) -> None:
        if self._participant is not None and self._waits_since_s is not None:
            self._waits_since_s = None
            self._participant.finish(is_idle=self._rgv.rover.is_idle)

    def _on_busy(self) -> None:
        if self._participant is not None:
            self._participant.report(is_idle=False)

    def _on_timer(self) -> None:
        self._step(floor_to(self.get_clock().now().nanoseconds, self._period_ns))


def _rgv(options: RgvOptions, name: str) -> Rgv:
    try:
        return Rgv(name, options)
    except (SimError, ViewError, ValueError, OSError) as error:
        raise ParameterError(f'{name}: {error}') from error


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(RgvNode)


if __name__ == '__main__':
    raise SystemExit(main())
