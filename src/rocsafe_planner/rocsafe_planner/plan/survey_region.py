# SPDX-License-Identifier: Apache-2.0
"""One of the regions of a survey."""

from dataclasses import dataclass

from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.vehicle import require_sensors


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyRegion:
    """An area to photograph, and the sensors that a vehicle needs for it besides its camera."""

    area: SurveyArea
    sensors: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        sensors = require_sensors(f'region {self.area.name!r}', self.sensors)
        object.__setattr__(self, 'sensors', sensors)
