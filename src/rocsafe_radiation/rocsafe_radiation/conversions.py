# SPDX-License-Identifier: Apache-2.0
"""Values of this package <-> messages."""

import math
from collections.abc import Sequence

from sensor_msgs.msg import NavSatFix

from rocsafe_interfaces.msg import GeoPoint, RadiationReading
from rocsafe_ros.conversions import has_position

IDEAL_DETECTOR = 'ideal'
Coordinates = tuple[float, float, float]
NOWHERE: Coordinates = (math.nan, math.nan, math.nan)


def coordinates_of_fix(fix: NavSatFix) -> Coordinates:
    """Return latitude and longitude in degrees and altitude in metres, all NaN without a fix."""
    return (fix.latitude, fix.longitude, fix.altitude) if has_position(fix) else NOWHERE


def coordinates_of_points(
    points: Sequence[GeoPoint],
) -> tuple[list[float], list[float], list[float]]:
    """Return the latitudes and longitudes in degrees and the altitudes in metres of `points`."""
    return (
        [point.latitude for point in points],
        [point.longitude for point in points],
        [point.altitude for point in points],
    )


def reading_of(
    fix: NavSatFix, vehicle: str, model: str, dose_rate_usvh: float
) -> RadiationReading:
    """Return what an ideal detector of `vehicle` reads at the time of `fix`.

    The position is where the vehicle believes it is, NaN without a fix.
    """
    latitude, longitude, altitude = coordinates_of_fix(fix)
    reading = RadiationReading(
        detector=IDEAL_DETECTOR,
        model=model,
        radiation_type=RadiationReading.RADIATION_TYPE_GAMMA,
        dose_rate_usvh=dose_rate_usvh,
        live_time_s=math.nan,
        position=GeoPoint(latitude=latitude, longitude=longitude, altitude=altitude),
    )
    reading.header.stamp = fix.header.stamp
    reading.header.frame_id = f'{vehicle}/radiation_sensor'
    return reading
