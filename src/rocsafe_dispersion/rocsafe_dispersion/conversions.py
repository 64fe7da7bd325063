# SPDX-License-Identifier: Apache-2.0
"""Values of this package <-> messages."""

import math

from sensor_msgs.msg import NavSatFix

from rocsafe_dispersion.air_field.air_field import GeoPlace
from rocsafe_dispersion.air_field.vehicle_sensors import Moment, WindMeasurement
from rocsafe_dispersion.detection.gas_sensor import GasSensor
from rocsafe_dispersion.detection.particle_counter import ParticleCount
from rocsafe_dispersion.detection.sensor_windows import GasMeasurement
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_interfaces.msg import GasReading, GeoPoint, ParticleReading, WindReading
from rocsafe_ros.conversions import has_position, ns_of_stamp, stamp_of_ns


def moment_of(fix: NavSatFix, truth: NavSatFix) -> Moment:
    """Return the moment of `fix` with its place and the true one."""
    return Moment(
        time_ns=ns_of_stamp(fix.header.stamp), place=place_of(truth), believed=place_of(fix)
    )


def place_of(fix: NavSatFix) -> GeoPlace:
    """Return latitude and longitude in degrees and altitude in metres, all NaN without a fix."""
    if not has_position(fix):
        return math.nan, math.nan, math.nan
    return fix.latitude, fix.longitude, fix.altitude


def seconds_since(start_ns: int, time_ns: int) -> float:
    """Return the seconds from `start_ns` to `time_ns`, both nanoseconds since 1970."""
    return (time_ns - start_ns) / NS_PER_S


def gas_reading_of(vehicle: str, sensor: GasSensor, measured: GasMeasurement) -> GasReading:
    """Return the reading of a gas sensor."""
    reading = GasReading(
        sensor=sensor.name,
        technology=sensor.technology,
        unit=sensor.unit,
        calibration_gas=sensor.calibration_gas,
        raw=measured.raw,
        corrected=measured.corrected,
        std=measured.std,
        limit=sensor.limit,
        bars=measured.bars,
        window_s=measured.window_s,
        below_limit=measured.is_below_limit,
        saturated=measured.is_saturated,
        position=_point(measured.believed),
    )
    reading.header.stamp = stamp_of_ns(measured.time_ns)
    reading.header.frame_id = f'{vehicle}/gas_sensor'
    return reading


def particle_reading_of(
    vehicle: str, time_ns: int, window_s: float, place: GeoPlace, count: ParticleCount
) -> ParticleReading:
    """Return the counts of a particle counter."""
    reading = ParticleReading(
        window_s=window_s,
        total=count.total,
        fluorescent=count.fluorescent,
        particles_per_l=count.particles_per_l,
        p_value=count.p_value,
        triggered=count.is_triggered,
        saturated=count.is_saturated,
        position=_point(place),
    )
    reading.header.stamp = stamp_of_ns(time_ns)
    reading.header.frame_id = f'{vehicle}/particle_counter'
    return reading


def wind_reading_of(
    vehicle: str, time_ns: int, window_s: float, place: GeoPlace, wind: WindMeasurement
) -> WindReading:
    """Return the wind that a vehicle measures."""
    east, north, up = wind.towards_mps
    reading = WindReading(
        towards_east_mps=east,
        towards_north_mps=north,
        towards_up_mps=up,
        std_mps=wind.std_mps,
        sigma_theta_rad=wind.sigma_theta_rad,
        window_s=window_s,
        tilt_corrected=True,
        position=_point(place),
    )
    reading.header.stamp = stamp_of_ns(time_ns)
    reading.header.frame_id = f'{vehicle}/anemometer'
    return reading


def _point(place: GeoPlace) -> GeoPoint:
    latitude, longitude, altitude = place
    return GeoPoint(latitude=latitude, longitude=longitude, altitude=altitude)
