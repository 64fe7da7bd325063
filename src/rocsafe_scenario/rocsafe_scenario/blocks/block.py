# SPDX-License-Identifier: Apache-2.0
"""What all blocks of a scenario have in common: their settings, and kinds of values.

Values are not converted: a string is not a number, and an unknown key is refused.
"""

from collections.abc import Callable
from dataclasses import fields
from datetime import datetime
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field

from rocsafe_geo.storage.utc_time import in_utc, time_of_text

# Names of ROS nodes and namespaces, reserved.
RESERVED_NAMES = frozenset(
    {'advisor', 'air', 'clock', 'collector', 'estimator', 'fleet', 'fleet_verbs', 'hazard',
     'localizer', 'mission', 'mosaic', 'orchestrator', 'plan', 'planner', 'radiation_field',
     'recorder', 'region', 'scene', 'shots', 'sim', 'world'}
)  # fmt: skip


def defaults_of(values: type) -> dict[str, Any]:
    """Return the defaults of a dataclass: each is written once, where the value is defined."""
    return {field.name: field.default for field in fields(values)}


def _within(name: str, low: float, high: float) -> Callable[[float], float]:
    def check(value: float) -> float:
        if not low <= value <= high:
            raise ValueError(f'{name} must be within {low:g} to {high:g}')
        return value

    return check


def _vehicle_name(name: str) -> str:
    if not name or not name[0].isalpha() or not name.replace('_', 'a').isalnum():
        raise ValueError('a vehicle name is a ROS namespace: a letter, then letters, digits or _')
    if not name.isascii() or '__' in name or name.endswith('_'):
        raise ValueError('a vehicle name is a ROS namespace: ASCII, no __ and no _ at its end')
    if name in RESERVED_NAMES:
        raise ValueError('is the name of a ROCSAFE node or topic; choose another')
    return name


UtcTime = Annotated[datetime, BeforeValidator(time_of_text), AfterValidator(in_utc)]
Latitude = Annotated[float, AfterValidator(_within('latitude', -90.0, 90.0))]
Longitude = Annotated[float, AfterValidator(_within('longitude', -180.0, 180.0))]
LatLon = tuple[Latitude, Longitude]
SensorName = Annotated[str, Field(pattern=r'^[A-Za-z][A-Za-z0-9_]*$', max_length=64)]
VehicleName = Annotated[str, Field(max_length=32), AfterValidator(_vehicle_name)]


class Block(BaseModel):
    """Settings of every block: unknown keys refused, nothing converted, no infinity, frozen."""

    model_config = ConfigDict(extra='forbid', strict=True, frozen=True, allow_inf_nan=False)
