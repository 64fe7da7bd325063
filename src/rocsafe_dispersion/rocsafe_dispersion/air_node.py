# SPDX-License-Identifier: Apache-2.0
"""The node ``air``: what the vehicles' gas sensors, particle counters and anemometers read."""

from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import NavSatFix

from rocsafe_dispersion.air_field.air_field import AirField
from rocsafe_dispersion.air_field.air_file import AirFile
from rocsafe_dispersion.air_field.air_making import air_field, read_air
from rocsafe_dispersion.air_field.air_options import AirOptions
from rocsafe_dispersion.air_field.vehicle_sensors import VehicleSensors, WindowEnd
from rocsafe_dispersion.conversions import (
    gas_reading_of,
    moment_of,
    particle_reading_of,
    seconds_since,
    wind_reading_of,
)
from rocsafe_ros.conversions import has_position
from rocsafe_ros.fix_pairs_node import FixPairs
from rocsafe_ros.interfaces import topics
from rocsafe_ros.lockstep import Participant
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run


class AirSensors:
    """The sensors of one vehicle: readings from its fixes, in the order of stamps."""

    def __init__(
        self, node: Node, vehicle: str, options: AirOptions, settings: AirFile, air: AirField
    ) -> None:
        self._vehicle = vehicle
        self._start_ns, self._window_s = options.start_time_ns, options.window_s
        self._sensors = VehicleSensors(vehicle, settings, air, options.window_s, options.seed)
        self._gas = topics.create_publisher(node, topics.GAS, vehicle)
        self._bio = topics.create_publisher(node, topics.BIO, vehicle)
        self._wind = topics.create_publisher(node, topics.ANEMOMETER, vehicle)
        self.fixes = FixPairs(
            node,
            vehicle,
            is_at_its_fix=vehicle in options.vehicles_at_their_fix,
            on_pair=self._answer,
        )

    def _answer(self, fix: NavSatFix, place: NavSatFix) -> None:
        if not has_position(place):
            return
        moment = moment_of(fix, place)
        readings = self._sensors.add(moment, seconds_since(self._start_ns, moment.time_ns))
        for sensor, measured in readings.gases:
            self._gas.publish(gas_reading_of(self._vehicle, sensor, measured))
        if readings.window is not None:
            self._publish_window(readings.window)

    def _publish_window(self, window: WindowEnd) -> None:
        common = (self._vehicle, window.time_ns, self._window_s, window.believed)
        if window.count is not None:
            self._bio.publish(particle_reading_of(*common, window.count))
        if window.wind is not None:
            self._wind.publish(wind_reading_of(*common, window.wind))


class AirNode(Node):
    """Publishes readings of gas, particles and wind at the vehicles' true positions.

    Subscribes for each vehicle: ``fix`` and ``ground_truth/fix``. Publishes for each vehicle:
    ``gas``, ``bio`` and ``anemometer``, as far as it carries these sensors, with the stamp of
    the end of each window.

    In lock-step it is the participant ``air``, and as ``radiation_field`` it reports a step as
    done at once: readings depend on stamps and positions, not on the order of arrival.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('air', **node_options)
        options = declare_options(self, AirOptions)
        try:
            settings = read_air(options)
            air = air_field(settings, options.seed)
            self._sensors = [
                AirSensors(self, vehicle, options, settings, air) for vehicle in options.vehicles
            ]
        except ValueError as error:
            raise ParameterError(str(error)) from error
        if options.lock_step:
            self._participant = Participant(self, self.get_name(), self._on_step, self._hears_all)

    def _hears_all(self) -> bool:
        return all(sensors.fixes.is_ready for sensors in self._sensors)

    def _on_step(self, _time_ns: int) -> bool:
        return True


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(AirNode)


if __name__ == '__main__':
    raise SystemExit(main())
