# SPDX-License-Identifier: Apache-2.0
"""Doses and alarms -> messages."""

import math

from std_msgs.msg import Header

from rocsafe_interfaces.msg import AccumulatedDose, DoseAlarm, DoseRate, RadiationReading
from rocsafe_radiation.detection.dosimeter import DOSE, Alarm, Dosimeter, Exposure
from rocsafe_radiation.readings.reading_log import FlightReading

SV_PER_USV = 1e-6


def exposure_of(reading: FlightReading) -> Exposure:
    """Return the part of a dose that `reading` adds; an invalid value adds nothing."""
    is_value = math.isfinite(reading.dose_rate_usvh) and reading.dose_rate_usvh >= 0.0
    return Exposure(
        time_ns=reading.time_ns,
        window_s=reading.window_s if math.isfinite(reading.window_s) else 0.0,
        dose_rate_usvh=reading.dose_rate_usvh if is_value else 0.0,
        is_saturated=reading.is_saturated or not is_value,
    )


def dose_rate_message(reading: RadiationReading) -> DoseRate:
    """Return `reading` with the fields of radiation_msgs."""
    return DoseRate(
        header=reading.header,
        radiation_type=reading.radiation_type,
        units=DoseRate.UNITS_SIEVERT_PER_HOUR,
        integration_time=reading.integration_time_s,
        rate=reading.dose_rate_usvh * SV_PER_USV,
    )


def dose_message(header: Header, dosimeter: Dosimeter) -> AccumulatedDose:
    """Return the dose so far."""
    return AccumulatedDose(
        header=header,
        radiation_type=RadiationReading.RADIATION_TYPE_GAMMA,
        units=AccumulatedDose.UNITS_SIEVERT,
        dose=dosimeter.dose_usv * SV_PER_USV,
        dose_usv=dosimeter.dose_usv,
        measured_s=dosimeter.measured_s,
        unmeasured_s=dosimeter.unmeasured_s,
        is_lower_limit=dosimeter.is_lower_limit,
    )


def alarm_message(header: Header, alarm: Alarm) -> DoseAlarm:
    """Return a level reached or left."""
    return DoseAlarm(
        header=header,
        threshold=alarm.threshold * SV_PER_USV,
        triggered=alarm.is_reached,
        quantity=DoseAlarm.DOSE if alarm.quantity == DOSE else DoseAlarm.DOSE_RATE,
        threshold_usv=alarm.threshold,
        value_usv=alarm.value,
        name=alarm.name,
        turns_back=alarm.turns_back,
    )
