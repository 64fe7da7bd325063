# SPDX-License-Identifier: Apache-2.0
"""The node ``estimator``: releases from all readings so far, while the vehicles fly."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from rclpy.node import Node

from rocsafe_dispersion.estimator_options import EstimatorOptions
from rocsafe_dispersion.mission_gas.gas_log import GasFlightReading, NoSurveyError
from rocsafe_dispersion.mission_gas.gas_spool import GasSpool
from rocsafe_dispersion.mission_gas.release_assessment import (
    ReleaseAssessment,
    assess,
    in_wind,
    suggested_places,
)
from rocsafe_dispersion.mission_gas.release_files import write_plume_files
from rocsafe_dispersion.release_conversions import (
    gas_flight_reading_of,
    particle_flight_reading_of,
    plume_message,
    releases_message,
    wind_flight_reading_of,
    zone_markers,
)
from rocsafe_hazard.conversions import fill_suggestion
from rocsafe_hazard.fit_cycle_node import FitCycle, FitSteps
from rocsafe_interfaces.msg import GasReading, ParticleReading, Region, WindReading
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_ros.conversions import area_of_region
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run


class EstimatorNode(Node):
    """Estimates releases of gas or particles from the readings of all vehicles.

    Subscribes: for each vehicle ``gas``, ``bio`` and ``anemometer``, and ``region``. Publishes:
    ``hazard/release``, ``hazard/plume`` and ``hazard/threat_zones`` (all latched), after each
    fit and where the wind has changed. Service: ``hazard/suggest_gas_viewpoints``.

    A node that is started again has the readings in its spool directory.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('estimator', **node_options)
        self._options = declare_options(self, EstimatorOptions)
        try:
            self._log, self._how = self._options.log(), self._options.assessment()
        except ValueError as error:
            raise ParameterError(f'{self.get_name()}: {error}') from error
        self._spool = GasSpool(self._options.spool_directory)
        self._spool.restore(self._log)
        self._region: Region | None = None
        self._releases = topics.create_publisher(self, topics.RELEASES)
        self._plumes = topics.create_publisher(self, topics.PLUME)
        self._zones = topics.create_publisher(self, topics.THREAT_ZONES)
        steps = FitSteps(
            prepare=self._prepare,
            refusals=(NoSurveyError,),
            publish=self._publish,
            period_s=self._options.period_s,
            renew=self._renew,
        )
        self._fits = FitCycle(self, self._log, steps)
        self._listen()

    def _listen(self) -> None:
        for vehicle in self._options.vehicles:
            topics.create_subscription(self, topics.GAS, partial(self._on_gas, vehicle), vehicle)
            topics.create_subscription(self, topics.BIO, partial(self._on_bio, vehicle), vehicle)
            on_wind = partial(self._on_wind, vehicle)
            topics.create_subscription(self, topics.ANEMOMETER, on_wind, vehicle)
        topics.create_subscription(self, topics.REGION, self._on_region)
        spec = calls.SUGGEST_GAS_VIEWPOINTS
        self.create_service(spec.call_type, spec.name, self._on_suggest)

    def _on_gas(self, vehicle: str, message: GasReading) -> None:
        self._add(gas_flight_reading_of(vehicle, message))

    def _on_bio(self, vehicle: str, message: ParticleReading) -> None:
        self._add(particle_flight_reading_of(vehicle, message))

    def _add(self, reading: GasFlightReading) -> None:
        if self._log.add_gas(reading):
            self._fits.note_reading()
            self._spool.keep_gas(reading)

    def _on_wind(self, vehicle: str, message: WindReading) -> None:
        reading = wind_flight_reading_of(vehicle, message)
        if self._log.add_wind(reading):
            self._spool.keep_wind(reading)

    def _on_region(self, region: Region) -> None:
        self._region = region

    def _prepare(self) -> Callable[[], ReleaseAssessment]:
        survey, folder = self._log.survey(), self._options.export_directory

        def fit() -> ReleaseAssessment:
            assessment = assess(survey, self._how)
            if folder:
                write_plume_files(Path(folder), assessment, self._log.frame)
            return assessment

        return fit

    def _renew(
        self, assessment: ReleaseAssessment
    ) -> tuple[Callable[[], ReleaseAssessment], int] | None:
        wind = self._log.recent_wind()
        if assessment.is_of_wind(wind):
            return None
        return partial(in_wind, assessment, wind), self._log.newest_wind_ns

    def _publish(self, assessment: ReleaseAssessment, time_ns: int) -> None:
        self._releases.publish(releases_message(assessment, self._log.frame, time_ns))
        self._zones.publish(zone_markers(assessment.zones, time_ns))
        self._plumes.publish(plume_message(assessment, time_ns))

    def _on_suggest(
        self, request: SuggestViewpoints.Request, response: SuggestViewpoints.Response
    ) -> SuggestViewpoints.Response:
        def fill(assessment: ReleaseAssessment) -> SuggestViewpoints.Response:
            frame = self._log.frame
            area = None if self._region is None else area_of_region(self._region).polygon(frame)
            count = 0 if assessment.verdict.is_enough else request.count
            places = suggested_places(assessment, count, area)
            return fill_suggestion(response, assessment.verdict, places, frame)

        return self._fits.answer(response, fill)


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(EstimatorNode)


if __name__ == '__main__':
    raise SystemExit(main())
