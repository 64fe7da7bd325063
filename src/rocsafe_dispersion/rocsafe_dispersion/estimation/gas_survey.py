# SPDX-License-Identifier: Apache-2.0
"""Readings of gas with the wind, as arrays that estimation works on."""

import math
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_dispersion.estimation.amount import GRAMS, Amount
from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray

LARGEST_READINGS = 20_000
# Readings of a mean are no further apart in any direction than this from the middle one, metres.
NEAR_M = 2.0
# Of a normal distribution: the share below one standard deviation under the mean, and the median
# of what is away from the mean, in standard deviations.
LOWER_SIGMA, PROBABLE_ERROR = 0.1587, 0.6745
NOISE_SHARE = 1e-3
BY_READING = (
    'places_m', 'wind_towards_mps', 'values_g_m3', 'std_g_m3', 'is_below', 'is_above', 'times_s',
    'instruments',
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GasSurvey:
    """Readings of point sensors or of beams.

    Attributes
    ----------
    places_m : (n, k, 3)
        East and north of the origin and height above the ground of the k points of each reading;
        k is 1 for point sensors.
    weights : (k,)
        Weight of each point of a beam; they add up to 1.
    wind_towards_mps : (n, 2)
        Mean wind during each reading, towards east and north, m/s.
    values_g_m3 : (n,)
        Mean concentration, g/m^3.
    std_g_m3 : (n,)
        Standard deviation of the sensor's noise, g/m^3, above 0.
    is_below : (n,)
        The reading says only that the concentration is below its value.
    is_above : (n,)
        The reading says only that the concentration is above its value.
    times_s : (n,)
        Times of the readings, seconds; their order only, if not `has_times`.
    instruments : (n,)
        Number of the instrument of each reading, from 0: each has a background of its own.
    has_times
        Whether the times are known.
    amount
        What readings count: grams, or particles, whose concentrations are in 1/m^3.
    """

    places_m: FloatArray
    weights: FloatArray
    wind_towards_mps: FloatArray
    values_g_m3: FloatArray
    std_g_m3: FloatArray
    is_below: BoolArray
    is_above: BoolArray
    times_s: FloatArray
    instruments: IndexArray
    has_times: bool = True
    amount: Amount = GRAMS

    def __post_init__(self) -> None:
        count = len(self.values_g_m3)
        if not 1 <= count <= LARGEST_READINGS:
            raise ValueError(f'{count} readings: must be 1 to {LARGEST_READINGS}')
        shapes = {
            'places_m': (count, len(self.weights), 3),
            'wind_towards_mps': (count, 2),
            'std_g_m3': (count,),
            'is_below': (count,),
            'is_above': (count,),
            'times_s': (count,),
            'instruments': (count,),
        }
        for name, shape in shapes.items():
            if np.shape(getattr(self, name)) != shape:
                raise ValueError(
                    f'{name} has shape {np.shape(getattr(self, name))}: must be {shape}'
                )
        for name in ('places_m', 'weights', 'wind_towards_mps', 'values_g_m3', 'times_s'):
            if not np.isfinite(getattr(self, name)).all():
                raise ValueError(f'{name} must be finite')
        if not (np.isfinite(self.std_g_m3).all() and (self.std_g_m3 > 0.0).all()):
            raise ValueError('std_g_m3 must be finite and above 0')
        if (self.instruments < 0).any():
            raise ValueError('instruments must be numbered from 0')

    @property
    def speeds_mps(self) -> FloatArray:
        """Wind speed of each reading, m/s."""
        return np.hypot(self.wind_towards_mps[:, 0], self.wind_towards_mps[:, 1])

    def only(self, kept: BoolArray) -> 'GasSurvey':
        """Return the survey of some readings, (n,)."""
        return replace(self, **{name: getattr(self, name)[kept] for name in BY_READING})


def point_survey(
    places_m: FloatArray,
    wind_towards_mps: FloatArray,
    values_g_m3: FloatArray,
    std_g_m3: FloatArray,
    times_s: FloatArray | None = None,
    *,
    is_below: BoolArray | None = None,
    is_above: BoolArray | None = None,
) -> GasSurvey:
    """Return the survey of one point sensor; places are (n, 3)."""
    count = len(values_g_m3)
    none = np.zeros(count, bool)
    return GasSurvey(
        places_m=np.asarray(places_m, float)[:, None],
        weights=np.ones(1),
        wind_towards_mps=wind_towards_mps,
        values_g_m3=values_g_m3,
        std_g_m3=std_g_m3,
        is_below=none if is_below is None else is_below,
        is_above=none if is_above is None else is_above,
        times_s=np.arange(count, dtype=float) if times_s is None else times_s,
        instruments=np.zeros(count, int),
        has_times=times_s is not None,
    )


def usual_noise(values: FloatArray) -> float:
    """Return the standard deviation of the noise of readings that mostly are of clean air.

    The larger one of two estimates for normal noise: what the lower half spreads, and how far
    readings that follow each other differ (a sensor that shows no value below 0 has no lower
    half). At least `NOISE_SHARE` of the largest reading (of the lowest one where none is above 0):
    readings that were computed have none.
    """
    low, middle = np.quantile(values, (LOWER_SIGMA, 0.5)).tolist()
    steps = float(np.median(np.abs(np.diff(values)))) if len(values) > 1 else 0.0
    found = max(middle - low, steps / (PROBABLE_ERROR * math.sqrt(2.0)))
    largest = float(values.max())
    return max(found, NOISE_SHARE * (largest if largest > 0.0 else -float(values.min())))


def averaged(survey: GasSurvey, most: int) -> GasSurvey:
    """Return a survey of about `most` readings: means over readings that follow each other.

    Readings of one instrument that say the same kind of thing (a value, or a bound) are taken in
    blocks in the order of their times. The mean is that of the readings near the middle one of the
    block, so that it has a place: a survey that is flown keeps readings of places, and one that
    stands gains by the mean.
    """
    count = len(survey.values_g_m3)
    if count <= most:
        return survey
    kinds = np.stack([survey.instruments, survey.is_below, survey.is_above])
    order = np.lexsort((survey.times_s, *kinds))
    ends = np.flatnonzero((np.diff(kinds[:, order]) != 0).any(axis=0)) + 1
    size = math.ceil(count / most)
    blocks = [
        part[start : start + size]
        for part in np.split(order, ends)
        for start in range(0, len(part), size)
    ]
    middles = np.array([block[len(block) // 2] for block in blocks])
    near = [
        block[np.abs(survey.places_m[block] - survey.places_m[middle]).max(axis=(1, 2)) <= NEAR_M]
        for block, middle in zip(blocks, middles.tolist(), strict=True)
    ]
    return replace(
        survey,
        places_m=survey.places_m[middles],
        wind_towards_mps=np.array([survey.wind_towards_mps[own].mean(axis=0) for own in near]),
        values_g_m3=np.array([survey.values_g_m3[own].mean() for own in near]),
        std_g_m3=np.array([np.linalg.norm(survey.std_g_m3[own]) / len(own) for own in near]),
        is_below=survey.is_below[middles],
        is_above=survey.is_above[middles],
        times_s=survey.times_s[middles],
        instruments=survey.instruments[middles],
    )
