# SPDX-License-Identifier: Apache-2.0
"""The worst and the newest reading of gas, of each unit: ppm and mg/m3 cannot be compared."""

import math
from dataclasses import asdict, dataclass, field
from typing import Any

from rocsafe_console.picture.coordinates import forms_of


@dataclass(frozen=True, slots=True, kw_only=True)
class GasNow:
    """A reading of a gas sensor, in its unit, as if of its calibration gas."""

    vehicle: str
    stamp_s: float
    value: float
    std: float
    unit: str
    sensor: str
    calibration_gas: str
    latitude_deg: float
    longitude_deg: float
    is_below_limit: bool = False
    is_saturated: bool = False


@dataclass(slots=True)
class GasReadings:
    """Worst and newest reading by unit, with the time of the wall at which each was heard."""

    _worst: dict[str, tuple[GasNow, float]] = field(default_factory=dict)
    _newest: dict[str, tuple[GasNow, float]] = field(default_factory=dict)

    def note(self, reading: GasNow, heard_s: float) -> None:
        """Take over a reading; one without a value is none."""
        if not math.isfinite(reading.value):
            return
        for kept, is_next in ((self._worst, _is_worse), (self._newest, _is_newer)):
            before = kept.get(reading.unit)
            if before is None or is_next(reading, before[0]):
                kept[reading.unit] = (reading, heard_s)

    def to_plain(self) -> list[dict[str, Any]]:
        """Return the readings of each unit, fit for JSON."""
        return [
            {'unit': unit, 'worst': _plain(*worst), 'newest': _plain(*self._newest[unit])}
            for unit, worst in sorted(self._worst.items())
        ]


def _is_worse(reading: GasNow, before: GasNow) -> bool:
    """Return whether a reading is above the worst so far; noise below the limit is none."""
    return (not reading.is_below_limit, reading.value) > (not before.is_below_limit, before.value)


def _is_newer(reading: GasNow, before: GasNow) -> bool:
    return reading.stamp_s >= before.stamp_s


def _plain(reading: GasNow, heard_s: float) -> dict[str, Any]:
    forms = forms_of(reading.latitude_deg, reading.longitude_deg)
    return {**asdict(reading), 'heard_s': heard_s, 'forms': forms}
