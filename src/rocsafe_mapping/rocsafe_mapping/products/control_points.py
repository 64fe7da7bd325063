# SPDX-License-Identifier: Apache-2.0
"""Errors of surveyed points on the map, and whether they make it unreliable."""

from typing import Any

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.mosaic.map_alignment import Alignment
from rocsafe_mapping.mosaic.survey import FoundPoint

LEAST_FIXES = 3
LARGEST_CHECK_FACTOR = 3.0
LARGEST_CONTROL_OFF_M = 10.0


def control_facts(alignment: Alignment) -> dict[str, Any]:
    """Return how far control and check points are off, with the stated error beside."""
    kinds = {
        'placing': [point for point in alignment.control if not point.is_check],
        'check': [point for point in alignment.control if point.is_check],
    }
    facts: dict[str, Any] = {
        kind: {
            'count': len(points),
            'rmse_m': round(_rms([point.off_m for point in points]), 4),
            'stated_error_m': round(
                _rms([np.array([_stated_at(alignment, point), 0.0]) for point in points]), 4
            ),
        }
        for kind, points in kinds.items()
        if points
    }
    facts['points'] = [
        {
            'name': point.name,
            'is_check': point.is_check,
            'off_east_m': round(float(point.off_m[0]), 4),
            'off_north_m': round(float(point.off_m[1]), 4),
            'stated_error_m': round(_stated_at(alignment, point), 4),
            'photographs': len(point.photos),
        }
        for point in alignment.control
    ]
    return facts


def _rms(values: list[FloatArray]) -> float:
    return float(np.sqrt(np.mean(np.sum(np.array(values) ** 2, axis=1))))


def _stated_at(alignment: Alignment, point: FoundPoint) -> float:
    """Return the stated error where a control point lies, on the mean of its photographs.

    Where surveyed points place the map, it is off as they are; otherwise the point itself may be.
    """
    place = point.place_m[np.newaxis]
    map_m = float(np.mean([alignment.errors_at_m(name, place)[0] for name in point.photos]))
    has_placing = any(not other.is_check for other in alignment.control)
    return map_m if has_placing else float(np.hypot(map_m, point.datum_error_m))


def control_violations(alignment: Alignment) -> list[str]:
    """Return why fixes and control points do not hold the map."""
    found = []
    placing = [point for point in alignment.control if not point.is_check]
    anchors = sum(photo.has_fix for photo in alignment.photos.values()) + len(placing)
    if anchors < LEAST_FIXES and not alignment.is_local:
        found.append(f'{anchors} fixes and control points hold the map, fewer than {LEAST_FIXES}')
    if placing and (off_m := _rms([point.off_m for point in placing])) > LARGEST_CONTROL_OFF_M:
        found.append(
            f'{len(placing)} control points are off by {off_m:.0f} m, more than '
            f'{LARGEST_CONTROL_OFF_M:g} m: places or pixels of some are wrong'
        )
    checks = [point for point in alignment.control if point.is_check]
    if checks:
        off_m = _rms([point.off_m for point in checks])
        stated_m = float(np.mean([_stated_at(alignment, point) for point in checks]))
        if off_m > LARGEST_CHECK_FACTOR * stated_m:
            found.append(
                f'{len(checks)} check points are off by {off_m:.2f} m, more than '
                f'{LARGEST_CHECK_FACTOR:g} times the stated {stated_m:.2f} m'
            )
    return found
