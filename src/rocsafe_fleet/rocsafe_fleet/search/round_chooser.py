# SPDX-License-Identifier: Apache-2.0
"""Chooses where a round of the search measures, from the readings of the ledger.

The estimator is that of the localizer. Equal readings give equal places, and only the coordinator
chooses: the others take the places from the ledger, so that machines need not compute equal
results.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from rocsafe_fleet.ledger.readings import DoseReading
from rocsafe_fleet.search.search_round import MOST_PLACES, MOST_ROUNDS, SearchRound
from rocsafe_geo.limits import require_count
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_radiation.errors import TooFewReadingsError
from rocsafe_radiation.localizer_options import LocalizerOptions
from rocsafe_radiation.products.assessment import assess, suggested_waypoints
from rocsafe_radiation.readings.ground import GroundError
from rocsafe_radiation.readings.reading_log import FlightReading

FEW_CELLS = 400
"""Cells of the map of dose rates that comes with an assessment, which nobody looks at here."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """How agents search after the survey.

    Attributes
    ----------
    extra_rounds
        Most rounds.
    viewpoints_a_round
        Most places of each.
    localizer
        How readings are assessed.
    """

    extra_rounds: int
    viewpoints_a_round: int
    localizer: LocalizerOptions

    def __post_init__(self) -> None:
        require_count('extra_rounds', self.extra_rounds, 1, MOST_ROUNDS)
        require_count('viewpoints_a_round', self.viewpoints_a_round, 1, MOST_PLACES)


class RoundChooser:
    """Chooses the places of rounds within an area."""

    def __init__(self, options: SearchOptions, area: SurveyArea) -> None:
        self._options, self._area = options, area

    def choose(self, number: int, readings: Iterable[tuple[str, DoseReading]]) -> SearchRound:
        """Return a round; one without places if the readings are enough, or too few."""
        try:
            log = self._options.localizer.log()
        except ValueError as error:
            return SearchRound(number=number, places=(), reason=str(error))
        for vehicle, one in readings:
            log.add(_flight_reading(vehicle, one))
        try:
            options = self._options.localizer.assessment(log.models)
            assessment = assess(log.survey(), options, log.vehicles, FEW_CELLS)
        except (GroundError, TooFewReadingsError) as refusal:
            return SearchRound(number=number, places=(), reason=str(refusal))
        frame, verdict = log.frame, assessment.verdict
        if frame is None or verdict.is_enough:
            return SearchRound(number=number, places=(), reason=verdict.reason)
        count, area = self._options.viewpoints_a_round, self._area.polygon(frame)
        found = suggested_waypoints(assessment, count, area)
        places = tuple(frame.position_of(one.place_m) for one in found)
        return SearchRound(number=number, places=places, reason=verdict.reason)


def _flight_reading(vehicle: str, one: DoseReading) -> FlightReading:
    here = one.position
    return FlightReading(
        vehicle=vehicle,
        time_ns=round(one.time_s * NS_PER_S),
        latitude_deg=here.latitude_deg,
        longitude_deg=here.longitude_deg,
        altitude_m=here.altitude_m,
        dose_rate_usvh=one.dose_rate_usvh,
        dose_rate_std_usvh=one.std_usvh,
        counts=one.counts,
        live_time_s=one.live_time_s if one.live_time_s > 0.0 else math.nan,
    )
