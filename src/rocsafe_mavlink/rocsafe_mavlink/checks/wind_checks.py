# SPDX-License-Identifier: Apache-2.0
"""Checks of wind and gusts, before a flight and during it."""

import math

from rocsafe_mavlink.checks.check import Check, CheckVerdict
from rocsafe_mavlink.knowledge.telemetry import Wind
from rocsafe_mavlink.plan.flight_limits import FlightLimits


def wind_fault(wind: Wind, limits: FlightLimits, now_s: float) -> str:
    """Return which limit the wind exceeds; empty if none does, or it is not known."""
    for word, measured_mps, limit_mps in (
        ('wind', wind.mean_mps(now_s), limits.max_wind_mps),
        ('gusts', wind.gust_mps(now_s), limits.max_gust_mps),
    ):
        if limit_mps > 0.0 and measured_mps > limit_mps:
            return f'{word} of {measured_mps:.1f} m/s: at most {limit_mps:g} m/s allowed'
    return ''


def wind_checks(wind: Wind, limits: FlightLimits, now_s: float) -> list[Check]:
    """Return the check before a flight; a vehicle that reports no wind gives a warning."""
    if limits.max_wind_mps <= 0.0 and limits.max_gust_mps <= 0.0:
        return []
    name = 'wind'
    parts = [
        f'{word} {limit_mps:g} m/s at most'
        for word, limit_mps in (('wind', limits.max_wind_mps), ('gusts', limits.max_gust_mps))
        if limit_mps > 0.0
    ]
    limit, mean_mps = ', '.join(parts), wind.mean_mps(now_s)
    if math.isnan(mean_mps):
        # An ArduCopter estimates none before it flies.
        return [Check(name, CheckVerdict.WARN, 'not told', limit)]
    verdict = CheckVerdict.FAIL if wind_fault(wind, limits, now_s) else CheckVerdict.PASS
    text = f'{mean_mps:.1f} m/s, gusts {wind.gust_mps(now_s):.1f} m/s'
    return [Check(name, verdict, text, limit)]
