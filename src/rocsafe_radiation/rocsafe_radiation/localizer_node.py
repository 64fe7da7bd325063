# SPDX-License-Identifier: Apache-2.0
"""The node ``localizer``: sources and doses from all readings so far, while the vehicles fly."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, cast

from rclpy.node import Node

from rocsafe_geo.frame import LocalFrame
from rocsafe_hazard.conversions import fill_suggestion
from rocsafe_hazard.fit_cycle_node import FitCycle, FitSteps
from rocsafe_interfaces.msg import RadiationReading, Region
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_radiation.assessment_conversions import (
    belief_message,
    cordon_markers,
    dose_map_message,
    sources_message,
)
from rocsafe_radiation.errors import TooFewReadingsError
from rocsafe_radiation.localizer_options import LocalizerOptions
from rocsafe_radiation.products.assessment import Assessment, assess, suggested_waypoints
from rocsafe_radiation.products.files import write_products
from rocsafe_radiation.readings.ground import GroundError
from rocsafe_radiation.readings.reading_spool import ReadingSpool
from rocsafe_radiation.vehicle_watch_node import VehicleWatch
from rocsafe_ros.conversions import area_of_region
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run


class LocalizerNode(Node):
    """Localises sources from the readings of all vehicles and adds up their doses.

    Subscribes: for each vehicle ``radiation``, and ``region``. Publishes: ``hazard/sources``,
    ``hazard/dose_map``, ``hazard/cordons`` and ``hazard/belief`` (all latched), after each fit;
    for each vehicle what `VehicleWatch` says. Service: ``hazard/suggest_viewpoints``.

    A node that is started again has the readings in its spool directory.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('localizer', **node_options)
        self._options = declare_options(self, LocalizerOptions)
        try:
            self._log = self._options.log()
        except ValueError as error:
            raise ParameterError(f'{self.get_name()}: {error}') from error
        self._spool = ReadingSpool(self._options.spool_directory)
        self._region: Region | None = None
        self._publish_to()
        levels = self._options.levels()
        self._watches = {name: VehicleWatch(self, name, levels) for name in self._options.vehicles}
        self._restore()
        steps = FitSteps(
            prepare=self._prepare,
            refusals=(GroundError, TooFewReadingsError),
            publish=self._publish,
            period_s=self._options.period_s,
        )
        self._fits = FitCycle(self, self._log, steps)
        self._listen()

    def _publish_to(self) -> None:
        self._sources = topics.create_publisher(self, topics.HAZARD_SOURCES)
        self._maps = topics.create_publisher(self, topics.DOSE_MAP)
        self._cordons = topics.create_publisher(self, topics.CORDONS)
        self._beliefs = topics.create_publisher(self, topics.BELIEF_MAP)

    def _listen(self) -> None:
        for vehicle in self._watches:
            on_reading = partial(self._on_reading, vehicle)
            topics.create_subscription(self, topics.RADIATION, on_reading, vehicle)
        topics.create_subscription(self, topics.REGION, self._on_region)
        spec = calls.SUGGEST_VIEWPOINTS
        self.create_service(spec.call_type, spec.name, self._on_suggest)

    def _restore(self) -> None:
        for reading in self._spool.restored():
            self._log.add(reading)
            if reading.vehicle in self._watches:
                self._watches[reading.vehicle].restore(reading)

    def _on_reading(self, vehicle: str, message: RadiationReading) -> None:
        reading = self._watches[vehicle].take(message)
        if reading is not None:
            self._log.add(reading)
            self._fits.note_reading()
            self._spool.keep(reading)

    def _on_region(self, region: Region) -> None:
        self._region = region

    def _prepare(self) -> Callable[[], Assessment]:
        try:
            survey = self._log.survey()
        except GroundError as error:
            self.get_logger().error(f'nothing localized: {error}', once=True)
            raise
        options = self._options.assessment(self._log.models)
        vehicles = self._log.vehicles
        frame, folder = self._log.frame, self._options.export_directory

        def fit() -> Assessment:
            assessment = assess(survey, options, vehicles)
            if folder:
                write_products(Path(folder), assessment, frame)
            return assessment

        return fit

    def _publish(self, assessment: Assessment, time_ns: int) -> None:
        self._sources.publish(sources_message(assessment, self._log.frame, time_ns))
        self._maps.publish(dose_map_message(assessment.dose, time_ns))
        self._cordons.publish(
            cordon_markers(assessment.cordons, assessment.survey.ground, time_ns)
        )
        if assessment.belief is not None:
            self._beliefs.publish(belief_message(assessment.belief, time_ns))

    def _on_suggest(
        self, request: SuggestViewpoints.Request, response: SuggestViewpoints.Response
    ) -> SuggestViewpoints.Response:
        def fill(assessment: Assessment) -> SuggestViewpoints.Response:
            frame = cast('LocalFrame', self._log.frame)  # that of its readings
            area = None if self._region is None else area_of_region(self._region).polygon(frame)
            count = 0 if assessment.verdict.is_enough else request.count
            waypoints = suggested_waypoints(assessment, count, area)
            return fill_suggestion(response, assessment.verdict, waypoints, frame)

        return self._fits.answer(response, fill)


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(LocalizerNode)


if __name__ == '__main__':
    raise SystemExit(main())
