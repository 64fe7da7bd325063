# SPDX-License-Identifier: Apache-2.0
"""Messages about gas -> values of this package."""

import math
from typing import Any

from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_console.conversions import geodetic_line, place_of, seconds_of
from rocsafe_console.picture.gas import GasNow
from rocsafe_geo.frame import LocalFrame
from rocsafe_interfaces.msg import GasReading, ReleaseEstimate, ReleaseEstimateArray
from rocsafe_view import formats


def releases_of(message: ReleaseEstimateArray) -> dict[str, Any]:
    """Return the estimated releases of gas or particles, and the verdict in words."""
    return {
        'stamp_s': seconds_of(message.header.stamp),
        'rate_unit': message.rate_unit,
        'agent': message.agent,
        'sensor': message.sensor,
        'verdict': message.verdict,
        'is_enough': message.is_enough,
        'releases': [_release_of(release) for release in message.releases],
    }


def gas_of(vehicle: str, message: GasReading) -> GasNow:
    """Return a reading of a gas sensor."""
    return GasNow(
        vehicle=vehicle,
        stamp_s=seconds_of(message.header.stamp),
        value=message.raw,
        std=message.std,
        unit=formats.gas_unit(message.unit),
        sensor=message.sensor,
        calibration_gas=message.calibration_gas,
        latitude_deg=message.position.latitude,
        longitude_deg=message.position.longitude,
        is_below_limit=message.below_limit,
        is_saturated=message.saturated,
    )


def threat_zones_of(message: MarkerArray, frame: LocalFrame) -> list[dict[str, Any]]:
    """Return the lines around threat zones as latitude and longitude.

    The name of a marker is its level and ``expected`` or ``outer``, the bound of 95 %.
    """
    zones = []
    for marker in message.markers:
        if marker.action == Marker.ADD and marker.type == Marker.LINE_STRIP:
            level, _, kind = marker.ns.rpartition(' ')
            parts = (marker.color.r, marker.color.g, marker.color.b)
            zones.append(
                {
                    'level': level,
                    'is_mean': kind == 'expected',
                    'colour': '#' + ''.join(f'{round(255 * part):02x}' for part in parts),
                    'ring': geodetic_line(frame, [(p.x, p.y, p.z) for p in marker.points]),
                }
            )
    return zones


def _release_of(release: ReleaseEstimate) -> dict[str, Any]:
    return {
        'id': release.id,
        'place': place_of(release.position),
        # A circle of the area that holds the place with a probability of 0.95.
        'radius_95_m': math.sqrt(release.region_95_m2 / math.pi),
        'rate': release.rate,
        'rate_low': release.rate_low,
        'rate_high': release.rate_high,
    }
