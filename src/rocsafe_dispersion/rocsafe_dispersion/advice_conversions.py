# SPDX-License-Identifier: Apache-2.0
"""Reports of people and advice on the agent <-> messages."""

import math
from datetime import datetime, timezone

from rocsafe_dispersion.identification.advice import Advice
from rocsafe_dispersion.identification.evidence import Report
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_interfaces.msg import AgentAdvice, AgentReport
from rocsafe_ros.conversions import ns_of_stamp, stamp_of_ns


def report_of(message: AgentReport) -> Report | int:
    """Return the report of a message, or the number of the placard that it tells.

    Raises
    ------
    ValueError
        If it tells neither or both, or what is not known.
    """
    if bool(message.un_number) == bool(message.observation):
        raise ValueError('a report must have either an observation or a un_number')
    if message.un_number:
        return int(message.un_number)
    place = message.position
    known = math.isfinite(place.latitude) and math.isfinite(place.longitude)
    return Report(
        observation=message.observation,
        is_true=message.is_true,
        witness=message.witness,
        time=_time(ns_of_stamp(message.header.stamp)),
        place_deg=(place.latitude, place.longitude) if known else None,
    )


def _time(time_ns: int) -> str:
    if not time_ns:
        return ''
    when = datetime.fromtimestamp(time_ns / NS_PER_S, timezone.utc)
    return when.isoformat(timespec='seconds').replace('+00:00', 'Z')


def advice_message(advice: Advice, time_ns: int) -> AgentAdvice:
    """Return advice with the stamp of the newest reading."""
    found, evidence = advice.found, advice.evidence
    message = AgentAdvice(
        agents=[name for name, _ in found.probabilities],
        probabilities=[probability for _, probability in found.probabilities],
        next_observations=[one.observation for one in found.next_observations],
        gains_bit=[one.gain_bit for one in found.next_observations],
        procedures=[f'{one.section.file}: {one.section.heading}' for one in advice.procedures],
        notes=advice.notes(),
        report_count=len(evidence.reports),
        sensors=[one.sensor for one in evidence.sensors],
        readings=[one.reading for one in evidence.sensors],
    )
    message.header.stamp = stamp_of_ns(time_ns)
    return message
