# SPDX-License-Identifier: Apache-2.0
"""Readings of a running flight, each once."""

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.ground_heights import GroundHeights
from rocsafe_radiation.readings.ground import LEVEL, ground_over
from rocsafe_radiation.readings.row_checks import dead, dead_caveats
from rocsafe_radiation.readings.survey import LocalReading, RadiationSurvey, survey_of


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightReading:
    """One reading of one vehicle; fields as in RadiationReading, its place NaN if unknown."""

    vehicle: str
    time_ns: int
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    dose_rate_usvh: float
    dose_rate_std_usvh: float = 0.0
    counts: float = 0.0
    live_time_s: float = math.nan
    window_s: float = 0.0
    is_saturated: bool = False
    model: str = ''

    @property
    def key(self) -> tuple[str, int]:
        """Vehicle and stamp in nanoseconds, unique to the reading."""
        return self.vehicle, self.time_ns

    @property
    def is_usable(self) -> bool:
        """Whether its place and its value are valid and it is not saturated."""
        place = (self.latitude_deg, self.longitude_deg, self.altitude_m)
        in_range = abs(self.latitude_deg) <= 90.0 and abs(self.longitude_deg) <= 180.0
        is_value = math.isfinite(self.dose_rate_usvh) and self.dose_rate_usvh >= 0.0
        return all(map(math.isfinite, place)) and in_range and is_value and not self.is_saturated


class ReadingLog:
    """Collects readings.

    Parameters
    ----------
    origin
        Origin of the frame, on the ground. At latitude and longitude 0 only its altitude counts,
        and the frame is about the first reading.
    sensitivity_cps_per_usvh
        Sensitivity of the detectors; 0: from counts and dose rate.
    heights
        Heights of the ground; None: it is level, at the origin's altitude.
    """

    def __init__(
        self,
        origin: GeoPosition,
        sensitivity_cps_per_usvh: float = 0.0,
        heights: GroundHeights | None = None,
    ) -> None:
        self._origin = origin
        self._sensitivity = sensitivity_cps_per_usvh
        self._heights = heights
        self._ground = LEVEL
        self._observations: dict[tuple[str, int], LocalReading] = {}
        is_known = bool(origin.latitude_deg or origin.longitude_deg)
        self.frame = LocalFrame(origin) if is_known else None
        self.models: set[str] = set()
        self.newest_ns = 0

    def __len__(self) -> int:
        return len(self._observations)

    @property
    def vehicles(self) -> tuple[str, ...]:
        """The vehicle of each reading of the survey."""
        return tuple(vehicle for vehicle, _ in self._observations)

    def add(self, reading: FlightReading) -> bool:
        """Add `reading` and return whether it is usable; a reading that comes again is ignored.

        Readings without a place or a value, and saturated ones, are not usable.
        """
        if reading.key in self._observations or not reading.is_usable:
            return False
        position = GeoPosition(reading.latitude_deg, reading.longitude_deg, reading.altitude_m)
        if self.frame is None:
            ground_m = self._origin.altitude_m
            self.frame = LocalFrame(
                GeoPosition(position.latitude_deg, position.longitude_deg, ground_m)
            )
        east, north, up = self.frame.enu_of(position).tolist()
        self._observations[reading.key] = LocalReading(
            position_enu_m=(east, north, up),
            dose_rate_usvh=reading.dose_rate_usvh,
            dose_rate_std_usvh=reading.dose_rate_std_usvh,
            counts=reading.counts,
            live_time_s=reading.live_time_s,
            vehicle=reading.vehicle,
            time_s=reading.time_ns / 1e9,
        )
        self.models.add(reading.model)
        self.newest_ns = max(self.newest_ns, reading.time_ns)
        return True

    def survey(self) -> RadiationSurvey:
        """Return all readings so far but those of a dead detector, over the ground if known."""
        observations = tuple(self._observations.values())
        amounts = np.array([one.counts + one.dose_rate_usvh for one in observations], np.float64)
        are_dead = dead(self.vehicles, amounts)
        if are_dead.any() and not are_dead.all():
            observations = tuple(itertools.compress(observations, ~are_dead))
        survey = survey_of(observations, self._sensitivity)
        survey = replace(survey, caveats=dead_caveats(int(are_dead.sum())))
        if self._heights is None or self.frame is None or not survey.size:
            return survey
        places = survey.positions_enu_m[:, :2]
        if not self._ground.reaches(places):
            self._ground = ground_over(self._heights, self.frame, places)
        return replace(survey, ground=self._ground)
