# SPDX-License-Identifier: Apache-2.0
"""Next places to measure: those where possible releases predict the most different readings.

Releases drawn from the posterior predict a reading at each place: the logarithm of the reading
above its noise. `rocsafe_hazard.next_places` chooses among them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.estimation.fluctuating_plume import PlumeReadings
from rocsafe_dispersion.estimation.found_release import ReleaseSamples
from rocsafe_dispersion.estimation.gas_survey import point_survey
from rocsafe_dispersion.plume.spread import Travel
from rocsafe_geo.arrays import FloatArray
from rocsafe_hazard.next_places import MeasuringPlace, next_places

# Standard deviation of the logarithm of one reading within a plume: eddies and the model.
LOG_SCATTER = 0.7


@dataclass(frozen=True, slots=True, kw_only=True)
class MeanAir:
    """The mean air that predictions are made for.

    Attributes
    ----------
    towards_mps
        Mean wind, towards east and north, m/s.
    travel
        How a plume spreads in it.
    reference_mps
        The wind that `travel` is for, m/s.
    release_height_m
        Height of releases above the ground, metres.
    """

    towards_mps: tuple[float, float]
    travel: Travel
    reference_mps: float
    release_height_m: float


def predicted(samples: ReleaseSamples, places_m: FloatArray, air: MeanAir) -> FloatArray:
    """Return the mean concentration of each sample at places (n, 3), (s, n), g/m^3."""
    count = len(places_m)
    survey = point_survey(
        places_m, np.tile(air.towards_mps, (count, 1)), np.zeros(count), np.ones(count)
    )
    readings = PlumeReadings(survey, air.release_height_m, air.travel, air.reference_mps)
    means, _ = readings.of(samples.places_m, samples.shapes)
    return np.asarray(samples.rates_g_s[:, None] * means)


def measuring_places(
    groups: Sequence[ReleaseSamples],
    candidates_m: FloatArray,
    air: MeanAir,
    noise_g_m3: float,
    count: int,
    placed: Sequence[ReleaseSamples] = (),
) -> list[MeasuringPlace]:
    """Return up to `count` of the candidates (n, 3), the one of most information first.

    Parameters
    ----------
    groups
        Samples of each release, equally many; a reading sees the sum of all releases.
    candidates_m
        Places that a vehicle can go to: east, north, height above the ground, metres.
    air
        The mean air.
    noise_g_m3
        Standard deviation of the noise of a reading, g/m^3.
    count
        How many.
    placed
        Samples of releases about which nothing more is asked: their mean plume covers others.
    """
    if not groups:
        return []
    total = sum(
        (predicted(samples, candidates_m, air) for samples in groups),
        np.zeros((len(groups[0].rates_g_s), len(candidates_m))),
    )
    for samples in placed:
        total = total + predicted(samples, candidates_m, air).mean(axis=0)
    logs = np.log1p(total / noise_g_m3)
    logs = (logs - logs.mean(axis=0)) / math.sqrt(len(logs))
    return next_places(candidates_m, logs, LOG_SCATTER**2, count)
