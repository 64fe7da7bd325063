# SPDX-License-Identifier: Apache-2.0
"""The node ``radiation_field``: readings of the vehicles' detectors in a simulated field."""

from functools import partial
from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import NavSatFix

from rocsafe_interfaces.srv import QueryRadiationField
from rocsafe_radiation.conversions import (
    coordinates_of_fix,
    coordinates_of_points,
    counted_reading_of,
    reading_of,
    sample_of,
    seconds_since,
)
from rocsafe_radiation.detection.counting import WindowCounter
from rocsafe_radiation.detection.survey_field import SurveyField
from rocsafe_radiation.errors import RadiationError, UnknownPointError
from rocsafe_radiation.field_parameters.field_making import survey_field
from rocsafe_radiation.field_parameters.field_options import FieldOptions
from rocsafe_radiation.physics.field import require_point
from rocsafe_ros.fix_pairs_node import FixPairs
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.lockstep import Participant
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run


class Detector:
    """The detector of one vehicle: readings from its fixes, in the order of stamps.

    The ideal detector gives a reading for each fix, others one for each window of time.
    """

    def __init__(
        self, node: Node, vehicle: str, options: FieldOptions, field: SurveyField
    ) -> None:
        self._log = node.get_logger()
        self._vehicle = vehicle
        self._model, self._kind = options.model, field.detector
        self._dose_rates_usvh = partial(field.flown_dose_rates_usvh, options.start_time_ns)
        kind = field.kind
        self._counter = (
            WindowCounter(kind, vehicle, options.window_s, options.seed, self._dose_rates_usvh)
            if kind
            else None
        )
        self._unanswered = 0
        self._readings = topics.create_publisher(node, topics.RADIATION, vehicle)
        self.fixes = FixPairs(
            node,
            vehicle,
            is_at_its_fix=vehicle in options.vehicles_at_their_fix,
            on_pair=self._answer,
        )

    def _answer(self, fix: NavSatFix, place: NavSatFix) -> None:
        try:
            require_point(*coordinates_of_fix(place))
        except UnknownPointError as error:
            self._count_unanswered(error)
            return
        sample = sample_of(fix, place)
        if self._counter is None:
            (dose_rate_usvh,) = self._dose_rates_usvh([sample])
            self._readings.publish(reading_of(fix, self._vehicle, self._model, dose_rate_usvh))
            return
        window = self._counter.add(sample)
        if window is not None:
            reading = counted_reading_of(window, self._vehicle, self._model, self._kind)
            self._readings.publish(reading)

    def _count_unanswered(self, error: UnknownPointError) -> None:
        self._unanswered += 1
        if self._unanswered == 1:
            self._log.warning(f'{self._vehicle}: no reading while its place is unknown: {error}')


class FieldNode(Node):
    """Publishes readings of the dose rate at the vehicles' true positions.

    Subscribes for each vehicle: ``fix`` and ``ground_truth/fix``. Publishes for each vehicle:
    ``radiation``, by the ideal detector with the stamp of each fix, by others with the stamp of
    the end of each window. Service: ``radiation_field/query``.

    In lock-step it is the participant ``radiation_field``. It cannot know whether a fix is due, so
    it reports a step as done at once; a later fix still gets a reading with its own stamp. Before
    its first report it waits for a connection to all vehicles, because earlier fixes may be lost.
    Its readings depend on stamps and positions, not on the order of arrival.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('radiation_field', **node_options)
        options = declare_options(self, FieldOptions)
        try:
            self._field = survey_field(options)
        except ValueError as error:
            raise ParameterError(str(error)) from error
        self._start_ns = options.start_time_ns
        self._detectors = [
            Detector(self, vehicle, options, self._field) for vehicle in options.vehicles
        ]
        self.create_service(calls.QUERY_FIELD.call_type, calls.QUERY_FIELD.name, self._on_query)
        if options.lock_step:
            self._participant = Participant(self, self.get_name(), self._on_step, self._hears_all)

    def _hears_all(self) -> bool:
        return all(detector.fixes.is_ready for detector in self._detectors)

    def _on_step(self, _time_ns: int) -> bool:
        return True

    def _on_query(
        self,
        request: QueryRadiationField.Request,
        response: QueryRadiationField.Response,
    ) -> QueryRadiationField.Response:
        try:
            rates_usvh = self._field.dose_rates_usvh(
                *coordinates_of_points(request.points),
                seconds_since(self._start_ns, self.get_clock().now().nanoseconds),
            )
        except RadiationError as error:
            response.error_code = QueryRadiationField.Request.INVALID_POINT
            response.error_msg = str(error)
            return response
        response.dose_rate_usvh = rates_usvh.tolist()
        return response


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(FieldNode)


if __name__ == '__main__':
    raise SystemExit(main())
