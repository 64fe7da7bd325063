# SPDX-License-Identifier: Apache-2.0
"""Measured values of the sensors, each with the variance of its error."""

from dataclasses import dataclass

Axes = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuReading:
    """Rates of turn and specific force along the axes of the body (forward, left, up).

    Attributes
    ----------
    time_ns
        Simulated time of the end of the sample.
    orientation_xyzw
        Estimated rotation from the body to east, north, up.
    rate_radps
        Mean rate of turn since the last sample.
    force_mps2
        Mean specific force since the last sample; at rest it is upwards.
    orientation_variance, rate_variance, force_variance
        On each axis: rad^2, rad^2/s^2, m^2/s^4.
    """

    time_ns: int
    orientation_xyzw: tuple[float, float, float, float]
    rate_radps: Axes
    force_mps2: Axes
    orientation_variance: float
    rate_variance: float
    force_variance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class PressureReading:
    """Pressure of the air, Pa."""

    time_ns: int
    pressure_pa: float
    variance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class MagneticReading:
    """Magnetic field along the axes of the body (forward, left, up), microtesla."""

    time_ns: int
    field_ut: Axes
    variance: float


@dataclass(frozen=True, slots=True, kw_only=True)
class RangeReading:
    """Distance along the beam, metres; by REP 117 infinite: nothing, -infinite: too near."""

    time_ns: int
    distance_m: float
    min_m: float
    max_m: float
    beam_rad: float
    variance: float


Reading = ImuReading | PressureReading | MagneticReading | RangeReading
