# SPDX-License-Identifier: Apache-2.0
"""Where to measure next: the places whose readings reduce the uncertainty most.

The information of a reading about the parameters is known before it is taken: w/m times the outer
product of the slopes of its expected counts. The next place is the one that most reduces the
volume of the sources' joint ellipse (D-optimal design, gain 1/2 log(1 + s' C s)).
"""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_hazard.next_places import MeasuringPlace, next_places
from rocsafe_radiation.localization.estimates import Localization
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import RadiationSurvey

LARGEST_GRID = 5000
PITCH_STEP_M = 0.5


def next_waypoints(
    found: Localization, candidates_enu_m: FloatArray, exposure: float, kernel: Kernel, count: int
) -> list[MeasuringPlace]:
    """Return up to `count` of the `candidates_enu_m`, shape (n, 3), the largest gain first.

    Parameters
    ----------
    found
        Sources found so far, at least one.
    candidates_enu_m
        Places that a vehicle can go to.
    exposure
        Counts of a reading there for 1 uSv/h.
    kernel
        Law of the dose rate.
    count
        Number of places, all of them different.
    """
    if not found.sources or count < 1:
        return []
    covariance: FloatArray = np.zeros((4 * len(found.sources),) * 2)
    for index, source in enumerate(found.sources):
        block = slice(4 * index, 4 * index + 4)
        covariance[block, block] = source.joint_covariance
    slopes = _scaled_slopes(found, candidates_enu_m, exposure, kernel)
    # A covariance may have no spread at all in a direction: no Cholesky factor.
    values, vectors = np.linalg.eigh(covariance)
    factor = (vectors * np.sqrt(np.maximum(values, 0.0))).T @ slopes.T
    return next_places(candidates_enu_m, factor, 1.0, count)


def candidate_places(survey: RadiationSurvey, source_height_m: float) -> FloatArray:
    """Return places at the height of a survey above its ground, half a height apart, (n, 3)."""
    height = survey.height_m(source_height_m)
    low, high = survey.positions_enu_m.min(axis=0), survey.positions_enu_m.max(axis=0)
    pitch = max(height / 2.0, math.sqrt(float(np.prod(high[:2] - low[:2]) / LARGEST_GRID)))
    # Rounded up, so that a single further reading does not move all places.
    pitch = PITCH_STEP_M * math.ceil(pitch / PITCH_STEP_M)
    axes = (np.arange(a, b + pitch, pitch) for a, b in zip(low[:2], high[:2], strict=True))
    east, north = (part.ravel() for part in np.meshgrid(*axes))
    ups = survey.ground.ups_at(np.stack([east, north], axis=1)) + source_height_m + round(height)
    return np.stack([east, north, ups], axis=1)


def log_volume(found: Localization) -> float:
    """Return the logarithm of the volume of the ellipses of all positions, east and north."""
    return 0.5 * math.fsum(
        float(np.linalg.slogdet(source.covariance_m2[:2, :2])[1]) for source in found.sources
    )


def _scaled_slopes(
    found: Localization, places: FloatArray, exposure: float, kernel: Kernel
) -> FloatArray:
    """Return the slopes of expected counts over their standard deviation, shape (n, 4 K)."""
    rates: FloatArray = np.full(len(places), found.background_usvh)
    parts = []
    for source in found.sources:
        offsets = places - source.position_enu_m
        values, by_square = kernel.values_and_slopes((offsets**2).sum(axis=1))
        strength = source.dose_rate_at_1m_usvh
        parts.append((-2.0 * strength * by_square)[:, None] * offsets)
        parts.append((strength * values)[:, None])
        rates = rates + strength * values
    # Errors of positions and gains make readings scatter beyond their counts.
    excess = exposure * (rates - found.background_usvh)
    counts = np.maximum(exposure * rates, 1e-9)
    deviations = np.sqrt(counts + (found.rho * excess) ** 2)
    return np.asarray(np.concatenate(parts, axis=1) * (exposure / deviations)[:, None])
