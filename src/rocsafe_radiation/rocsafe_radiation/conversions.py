# SPDX-License-Identifier: Apache-2.0
"""Values of this package <-> messages."""

import math
from collections.abc import Sequence

from sensor_msgs.msg import NavSatFix

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_interfaces.msg import GeoPoint, RadiationReading
from rocsafe_radiation.detection.counting import Sample, WindowReading
from rocsafe_radiation.detection.detector import IDEAL
from rocsafe_radiation.readings.reading_log import FlightReading
from rocsafe_ros.conversions import has_position, ns_of_stamp, stamp_of_ns

Coordinates = tuple[float, float, float]
NOWHERE: Coordinates = (math.nan, math.nan, math.nan)


def coordinates_of_fix(fix: NavSatFix) -> Coordinates:
    """Return latitude and longitude in degrees and altitude in metres, all NaN without a fix."""
    return (fix.latitude, fix.longitude, fix.altitude) if has_position(fix) else NOWHERE


def seconds_since(start_ns: int, time_ns: int) -> float:
    """Return the seconds from `start_ns` to `time_ns`, both nanoseconds since 1970."""
    return (time_ns - start_ns) / NS_PER_S


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
    """Return the reading of an ideal detector of `vehicle` at the time of `fix`.

    The position is where the vehicle believes it is, NaN without a fix.
    """
    latitude, longitude, altitude = coordinates_of_fix(fix)
    reading = RadiationReading(
        detector=IDEAL,
        model=model,
        radiation_type=RadiationReading.RADIATION_TYPE_GAMMA,
        dose_rate_usvh=dose_rate_usvh,
        live_time_s=math.nan,
        position=GeoPoint(latitude=latitude, longitude=longitude, altitude=altitude),
    )
    reading.header.stamp = fix.header.stamp
    reading.header.frame_id = f'{vehicle}/radiation_sensor'
    return reading


def sample_of(fix: NavSatFix, truth: NavSatFix) -> Sample:
    """Return the moment of `fix` with its place and the true one."""
    return Sample(
        time_ns=ns_of_stamp(fix.header.stamp),
        place=coordinates_of_fix(truth),
        believed=coordinates_of_fix(fix),
    )


def counted_reading_of(
    window: WindowReading, vehicle: str, model: str, detector: str
) -> RadiationReading:
    """Return the reading of `detector` of `vehicle` at the end of `window`."""
    measured = window.measurement
    reading = RadiationReading(
        detector=detector,
        model=model,
        radiation_type=RadiationReading.RADIATION_TYPE_GAMMA,
        dose_rate_usvh=measured.dose_rate_usvh,
        dose_rate_std_usvh=measured.dose_rate_std_usvh,
        counts=measured.counts,
        integration_time_s=measured.window_s,
        live_time_s=measured.live_time_s,
        saturated=measured.is_saturated,
        position=GeoPoint(
            latitude=window.latitude_deg,
            longitude=window.longitude_deg,
            altitude=window.altitude_m,
        ),
    )
    reading.header.stamp = stamp_of_ns(window.time_ns)
    reading.header.frame_id = f'{vehicle}/radiation_sensor'
    return reading


def flight_reading_of(vehicle: str, reading: RadiationReading) -> FlightReading:
    """Return the reading of `vehicle` in a message."""
    return FlightReading(
        vehicle=vehicle,
        time_ns=ns_of_stamp(reading.header.stamp),
        latitude_deg=reading.position.latitude,
        longitude_deg=reading.position.longitude,
        altitude_m=reading.position.altitude,
        dose_rate_usvh=reading.dose_rate_usvh,
        dose_rate_std_usvh=reading.dose_rate_std_usvh,
        counts=float(reading.counts),
        live_time_s=reading.live_time_s,
        window_s=reading.integration_time_s,
        is_saturated=reading.saturated,
        model=reading.model,
    )
