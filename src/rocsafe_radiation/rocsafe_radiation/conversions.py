# SPDX-License-Identifier: Apache-2.0
"""Values of this package <-> messages."""

import math
from collections.abc import Sequence

import numpy as np
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import NavSatFix

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.msg import GeoPoint, HazardSource, HazardSourceArray, RadiationReading
from rocsafe_radiation.counting import NS_PER_S, Sample, WindowReading
from rocsafe_radiation.detector import IDEAL
from rocsafe_radiation.dose_map import DoseMap
from rocsafe_radiation.localization import METHOD, Localization, SourceEstimate
from rocsafe_radiation.reading_log import ReadingLog
from rocsafe_radiation.survey import Observation
from rocsafe_ros.conversions import (
    has_position,
    ns_of_stamp,
    point_of_position,
    position_of_point,
    stamp_of_ns,
)

Coordinates = tuple[float, float, float]
# Cells of the dose map: 0 is 0.1 uSv/h or less, each 10 is a factor of 4, 100 is 1e5 or more.
LOWEST_CELL_USVH, DECADES = 0.1, 6.0
NOWHERE: Coordinates = (math.nan, math.nan, math.nan)


def coordinates_of_fix(fix: NavSatFix) -> Coordinates:
    """Return latitude and longitude in degrees and altitude in metres, all NaN without a fix."""
    return (fix.latitude, fix.longitude, fix.altitude) if has_position(fix) else NOWHERE


def mission_time_s(fix: NavSatFix, start_ns: int) -> float:
    """Return the time of `fix` after the start of the mission, seconds."""
    return seconds_since(start_ns, ns_of_stamp(fix.header.stamp))


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
    """Return what an ideal detector of `vehicle` reads at the time of `fix`.

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


def sample_of(fix: NavSatFix, dose_rate_usvh: float) -> Sample:
    """Return the field at the time of `fix`, with the place that it states."""
    latitude, longitude, altitude = coordinates_of_fix(fix)
    return Sample(
        time_ns=ns_of_stamp(fix.header.stamp),
        dose_rate_usvh=float(dose_rate_usvh),
        latitude_deg=latitude,
        longitude_deg=longitude,
        altitude_m=altitude,
    )


def counted_reading_of(
    window: WindowReading, vehicle: str, model: str, detector: str
) -> RadiationReading:
    """Return what `detector` of `vehicle` reads at the end of `window`."""
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


def reading_key(vehicle: str, reading: RadiationReading) -> tuple[str, int]:
    """Return what tells a reading from all others: vehicle and stamp in nanoseconds."""
    return vehicle, ns_of_stamp(reading.header.stamp)


def place_of_reading(reading: RadiationReading) -> GeoPosition | None:
    """Return where the vehicle believed it was, None if it did not know."""
    try:
        return position_of_point(reading.position)
    except ValueError:
        return None


def observation_of(reading: RadiationReading) -> Observation:
    """Return what `reading` says, without its place."""
    return Observation(
        position_enu_m=NOWHERE,
        dose_rate_usvh=reading.dose_rate_usvh,
        dose_rate_std_usvh=reading.dose_rate_std_usvh,
        counts=float(reading.counts),
        live_time_s=reading.live_time_s,
    )


def sources_message(found: Localization, log: ReadingLog) -> HazardSourceArray:
    """Return what was found in the readings of `log`, with the stamp of the newest."""
    message = HazardSourceArray(
        sources=[
            _source_message(number, source, found, log.frame)
            for number, source in enumerate(found.sources, 1)
            if log.frame is not None
        ],
        source_count_probability=list(found.order_probabilities),
        background_usvh=found.background_usvh,
        background_std_usvh=found.background_std_usvh,
        method=METHOD,
    )
    message.header.stamp = stamp_of_ns(log.newest_ns)
    message.header.frame_id = 'earth'
    return message


def _source_message(
    number: int, source: SourceEstimate, found: Localization, frame: LocalFrame
) -> HazardSource:
    return HazardSource(
        id=number,
        kind=HazardSource.GAMMA,
        position=point_of_position(frame.position_of(source.position_enu_m)),
        position_covariance=source.covariance_m2.ravel().tolist(),
        dose_rate_at_1m_usvh=source.dose_rate_at_1m_usvh,
        dose_rate_at_1m_std_usvh=source.dose_rate_at_1m_std_usvh,
        detection_log_likelihood_ratio=source.detection_llr,
        reading_count=found.reading_count,
    )


def dose_map_message(found: DoseMap, log: ReadingLog) -> OccupancyGrid:
    """Return the mean of `found`, log-scaled: 0 at 0.1 uSv/h and below, 100 at 1e5 and above.

    The frame is that of the log, the mission's.
    """
    rows, columns = found.mean_usvh.shape
    decades = np.log10(np.maximum(found.mean_usvh, LOWEST_CELL_USVH) / LOWEST_CELL_USVH)
    cells = np.clip(np.round(100.0 * decades / DECADES), 0, 100).astype(np.int8)
    message = OccupancyGrid(data=cells.ravel().tolist())
    message.header.stamp = stamp_of_ns(log.newest_ns)
    message.header.frame_id = 'map'
    message.info.resolution = float(found.cell_m)
    message.info.width, message.info.height = columns, rows
    message.info.origin.position.x, message.info.origin.position.y = found.corner_m
    message.info.origin.orientation.w = 1.0
    return message
