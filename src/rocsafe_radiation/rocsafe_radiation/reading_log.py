# SPDX-License-Identifier: Apache-2.0
"""Readings of a flight as they come, each once, ready to be localised at any time."""

import math
from collections.abc import Hashable

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.survey import Observation, Survey, survey_of


class ReadingLog:
    """Collects readings.

    Parameters
    ----------
    origin: of the frame, on the ground. At latitude and longitude 0 only its altitude counts: the
        frame is about the first reading.
    sensitivity_cps_per_usvh: of the detectors; 0: from counts and dose rate.
    """

    def __init__(self, origin: GeoPosition, sensitivity_cps_per_usvh: float = 0.0) -> None:
        self._origin = origin
        self._sensitivity = sensitivity_cps_per_usvh
        self._seen: set[Hashable] = set()
        self._observations: list[Observation] = []
        is_known = bool(origin.latitude_deg or origin.longitude_deg)
        self.frame = LocalFrame(origin) if is_known else None
        self.models: set[str] = set()
        self.newest_ns = 0

    def __len__(self) -> int:
        return len(self._observations)

    def add(
        self, key: tuple[str, int], position: GeoPosition, observation: Observation, model: str
    ) -> bool:
        """Take a reading at `position` and return whether it is of use.

        `key` is its vehicle and stamp in nanoseconds: what comes again is not counted twice. The
        place of `observation` does not matter.
        """
        coordinates = (position.latitude_deg, position.longitude_deg, position.altitude_m)
        if key in self._seen or not all(map(math.isfinite, coordinates)):
            return False
        self._seen.add(key)
        if self.frame is None:
            ground = GeoPosition(
                latitude_deg=position.latitude_deg,
                longitude_deg=position.longitude_deg,
                altitude_m=self._origin.altitude_m,
            )
            self.frame = LocalFrame(ground)
        east, north, up = self.frame.enu_of(position).tolist()
        self._observations.append(
            Observation(
                position_enu_m=(east, north, up),
                dose_rate_usvh=observation.dose_rate_usvh,
                dose_rate_std_usvh=observation.dose_rate_std_usvh,
                counts=observation.counts,
                live_time_s=observation.live_time_s,
            )
        )
        self.models.add(model)
        self.newest_ns = max(self.newest_ns, key[1])
        return True

    def survey(self) -> Survey:
        """Return all readings so far."""
        return survey_of(self._observations, self._sensitivity)
