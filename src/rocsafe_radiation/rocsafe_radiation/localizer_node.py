# SPDX-License-Identifier: Apache-2.0
"""The node ``localizer``: sources from all readings so far, while the vehicles fly."""

from functools import partial
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_interfaces.msg import RadiationReading
from rocsafe_radiation.conversions import (
    dose_map_message,
    observation_of,
    place_of_reading,
    reading_key,
    sources_message,
)
from rocsafe_radiation.localization import TooFewReadingsError
from rocsafe_radiation.localization_job import LocalizationJob, picture_of
from rocsafe_radiation.localizer_options import LocalizerOptions
from rocsafe_radiation.reading_log import ReadingLog
from rocsafe_ros import topics
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.run import run

# How often a running fit is looked at, on the wall clock: simulated time may stand still.
WATCH_PERIOD_S = 0.1


class LocalizerNode(Node):
    """Localises sources from the readings of all vehicles.

    Subscribes: for each vehicle ``radiation``. Publishes: ``hazard/sources`` and
    ``hazard/dose_map`` (latched), after each fit. A fit begins when the last is done, the period
    has passed and there are new readings, so the last one covers all readings; those in between
    depend on how fast this machine is.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('localizer', **node_options)
        self._options = declare_options(self, LocalizerOptions)
        self._log = ReadingLog(self._options.origin(), self._options.sensitivity_cps_per_usvh)
        self._job: LocalizationJob | None = None
        self._fitted = 0
        self._looks_to_wait = 0
        self._sources = topics.create_publisher(self, topics.HAZARD_SOURCES)
        self._maps = topics.create_publisher(self, topics.DOSE_MAP)
        for vehicle in self._options.vehicles:
            on_reading = partial(self._on_reading, vehicle)
            topics.create_subscription(self, topics.RADIATION, on_reading, vehicle)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = self.create_timer(WATCH_PERIOD_S, self._on_watch, clock=steady)

    def _on_reading(self, vehicle: str, reading: RadiationReading) -> None:
        place = place_of_reading(reading)
        if place is not None and not reading.saturated:
            key = reading_key(vehicle, reading)
            self._log.add(key, place, observation_of(reading), reading.model)

    def _on_watch(self) -> None:
        if self._job is not None and self._job.is_done:
            self._publish(self._job)
            self._job = None
        self._looks_to_wait -= 1
        if self._job is None and self._looks_to_wait < 0 and len(self._log) > self._fitted:
            self._looks_to_wait = self._options.looks_a_fit(WATCH_PERIOD_S)
            self._fitted = len(self._log)
            work = partial(picture_of, self._log.survey(), self._options.localization(self._log))
            self._job = LocalizationJob(work)

    def _publish(self, job: LocalizationJob) -> None:
        try:
            picture = job.result()
        except TooFewReadingsError:
            return
        self._sources.publish(sources_message(picture.found, self._log))
        self._maps.publish(dose_map_message(picture.dose, self._log))


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(LocalizerNode)


if __name__ == '__main__':
    raise SystemExit(main())
