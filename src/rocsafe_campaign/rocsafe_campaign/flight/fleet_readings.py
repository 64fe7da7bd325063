# SPDX-License-Identifier: Apache-2.0
"""The readings of the detectors of a fleet along its flight."""

from collections.abc import Iterable
from pathlib import Path

from rocsafe_campaign.flight.fleet_flight import TimedFix
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.value_file import values_of
from rocsafe_orchestrator.parameters.field_parameters import field_parameters
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_radiation.detection.counting import Place, Sample, WindowCounter, WindowReading
from rocsafe_radiation.detection.survey_field import SurveyField
from rocsafe_radiation.field_parameters.field_file import FieldFile
from rocsafe_radiation.field_parameters.field_making import field_of
from rocsafe_radiation.field_parameters.field_options import FieldOptions
from rocsafe_radiation.readings.reading_log import FlightReading
from rocsafe_scenario.scenario import Scenario

# Scenarios flown here name no file that a run would export to its folder.
NOWHERE = RunDirectory(Path())


def readings_along(scenario: Scenario, fixes: Iterable[TimedFix]) -> tuple[FlightReading, ...]:
    """Return the readings of the detectors of all vehicles, in the order of time.

    The same as those of the process `radiation_field` from the same fixes.

    Raises
    ------
    ValueError
        If the sources or the ground are wrong, in a line for each mistake.
    """
    parameters = field_parameters(scenario, NOWHERE)
    content = parameters.pop('field_file')
    for key in ('vehicles', 'vehicles_at_their_fix'):
        parameters[key] = tuple(parameters[key])
    options = FieldOptions(**parameters)
    field = field_of(options, values_of(content, FieldFile, scenario.name), Path())
    detectors = {vehicle: _Detector(vehicle, options, field) for vehicle in scenario.vehicle_names}
    taken = (detectors[each.vehicle].reading(each) for each in fixes)
    return tuple(reading for reading in taken if reading is not None)


class _Detector:
    """The detector of one vehicle; the ideal one reads at each fix, others over windows."""

    def __init__(self, vehicle: str, options: FieldOptions, field: SurveyField) -> None:
        self._vehicle, self._options, self._field = vehicle, options, field
        kind = field.kind
        self._counter = (
            WindowCounter(kind, vehicle, options.window_s, options.seed, self._rates)
            if kind
            else None
        )

    def _rates(self, samples: Iterable[Sample]) -> FloatArray:
        return self._field.flown_dose_rates_usvh(self._options.start_time_ns, tuple(samples))

    def reading(self, fix: TimedFix) -> FlightReading | None:
        """Return the reading that a fix completes, if any."""
        sample = Sample(
            time_ns=fix.time_ns,
            place=_coordinates(fix.fix.true_position),
            believed=_coordinates(fix.fix.position),
        )
        if self._counter is None:
            latitude, longitude, altitude = sample.believed
            return FlightReading(
                vehicle=self._vehicle,
                time_ns=sample.time_ns,
                latitude_deg=latitude,
                longitude_deg=longitude,
                altitude_m=altitude,
                dose_rate_usvh=float(self._rates([sample])[0]),
                model=self._options.model,
            )
        window = self._counter.add(sample)
        return None if window is None else self._counted(window)

    def _counted(self, window: WindowReading) -> FlightReading:
        measured = window.measurement
        return FlightReading(
            vehicle=self._vehicle,
            time_ns=window.time_ns,
            latitude_deg=window.latitude_deg,
            longitude_deg=window.longitude_deg,
            altitude_m=window.altitude_m,
            dose_rate_usvh=measured.dose_rate_usvh,
            dose_rate_std_usvh=measured.dose_rate_std_usvh,
            counts=float(measured.counts),
            live_time_s=measured.live_time_s,
            window_s=measured.window_s,
            is_saturated=measured.is_saturated,
            model=self._options.model,
        )


def _coordinates(position: GeoPosition) -> Place:
    return position.latitude_deg, position.longitude_deg, position.altitude_m
