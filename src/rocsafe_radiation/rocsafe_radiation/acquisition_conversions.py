# SPDX-License-Identifier: Apache-2.0
"""Measurements and health of a real detector -> messages."""

import math

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_interfaces.msg import GeoPoint, RadiationReading, VehicleEvent
from rocsafe_radiation.acquisition.acquisition import AcquiredMeasurement, AcquisitionHealth
from rocsafe_ros.conversions import stamp_of_ns

KIND = 'detector'


def acquired_reading_of(
    acquired: AcquiredMeasurement, vehicle: str, detector: str
) -> RadiationReading:
    """Return a measurement of `detector` of `vehicle` as a reading."""
    measured = acquired.measurement
    latitude, longitude, altitude = acquired.place
    return RadiationReading(
        header=Header(
            stamp=stamp_of_ns(round(acquired.time_s * NS_PER_S)),
            frame_id=f'{vehicle}/radiation_sensor',
        ),
        detector=detector,
        radiation_type=RadiationReading.RADIATION_TYPE_GAMMA,
        dose_rate_usvh=measured.dose_rate_usvh,
        dose_rate_std_usvh=measured.dose_rate_std_usvh,
        counts=measured.counts,
        integration_time_s=measured.window_s,
        live_time_s=measured.live_time_s,
        saturated=measured.is_saturated,
        position=GeoPoint(latitude=latitude, longitude=longitude, altitude=altitude),
    )


def health_status(health: AcquisitionHealth, vehicle: str) -> DiagnosticStatus:
    """Return the health of the detector of `vehicle`: silence is an error."""
    values: dict[str, object] = {
        'measured': health.measured,
        'without a place': health.unplaced,
        **{f'bad lines, {kind}': count for kind, count in sorted(health.bad.items())},
    }
    if health.last_bad:
        values['last bad line'] = health.last_bad
    if not math.isnan(health.clock_offset_s):
        values['our clock less that of the detector, s'] = f'{health.clock_offset_s:.3f}'
    level = DiagnosticStatus.WARN if health.bad else DiagnosticStatus.OK
    return DiagnosticStatus(
        name=f'detector: {vehicle}',
        hardware_id=vehicle,
        level=DiagnosticStatus.ERROR if health.is_silent else level,
        message=_words(health),
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )


def health_event(health: AcquisitionHealth, vehicle: str, stamp: Time) -> VehicleEvent:
    """Return that the detector fell silent, or is heard again."""
    return VehicleEvent(
        header=Header(stamp=stamp, frame_id=f'{vehicle}/radiation_sensor'),
        vehicle=vehicle,
        severity=VehicleEvent.ERROR if health.is_silent else VehicleEvent.INFO,
        kind=KIND,
        text=_words(health),
    )


def _words(health: AcquisitionHealth) -> str:
    if health.is_silent:
        return (
            f'the detector is silent for {health.silent_s:.0f} s: no reading is no proof that '
            'there is nothing'
        )
    return 'the detector is heard'
