# SPDX-License-Identifier: Apache-2.0
"""Topics from the readings of one vehicle: dose rate, dose and alarms."""

from rclpy.node import Node

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_interfaces.msg import RadiationReading
from rocsafe_radiation.conversions import flight_reading_of
from rocsafe_radiation.detection.dosimeter import AlarmLevels, Dosimeter
from rocsafe_radiation.dose_conversions import (
    alarm_message,
    dose_message,
    dose_rate_message,
    exposure_of,
)
from rocsafe_radiation.readings.reading_log import FlightReading
from rocsafe_ros.interfaces import topics

# Between two messages of the dose, which grows with each reading.
DOSE_PERIOD_NS = NS_PER_S


class VehicleWatch:
    """Adds up the dose of one vehicle and publishes it.

    Publishes, in the namespace of the vehicle: ``dose_rate`` with each reading,
    ``accumulated_dose`` at most once a second of their stamps, ``dose_alarm`` when a level is
    reached or left.
    """

    def __init__(self, node: Node, vehicle: str, levels: AlarmLevels) -> None:
        self._log = node.get_logger()
        self._vehicle = vehicle
        self._dosimeter = Dosimeter(levels)
        self._rates = topics.create_publisher(node, topics.DOSE_RATE, vehicle)
        self._doses = topics.create_publisher(node, topics.ACCUMULATED_DOSE, vehicle)
        self._alarms = topics.create_publisher(node, topics.DOSE_ALARM, vehicle)
        self._told_ns = -DOSE_PERIOD_NS

    def restore(self, reading: FlightReading) -> None:
        """Add a reading that was published before."""
        self._dosimeter.add(exposure_of(reading))

    def take(self, message: RadiationReading) -> FlightReading | None:
        """Publish a reading and return it, None if it is not new."""
        reading = flight_reading_of(self._vehicle, message)
        alarms = self._dosimeter.add(exposure_of(reading))
        if alarms is None:
            return None
        self._rates.publish(dose_rate_message(message))
        if reading.time_ns - self._told_ns >= DOSE_PERIOD_NS:
            self._told_ns = reading.time_ns
            self._doses.publish(dose_message(message.header, self._dosimeter))
        for alarm in alarms:
            self._alarms.publish(alarm_message(message.header, alarm))
            verb = 'reached' if alarm.is_reached else 'left'
            self._log.warning(f'{self._vehicle} has {verb} {alarm.name}: {alarm.value:.4g}')
        return reading
