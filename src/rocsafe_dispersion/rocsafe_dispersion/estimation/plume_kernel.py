# SPDX-License-Identifier: Apache-2.0
"""What each reading would be for a release of 1 g/s at each of many places."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.plume.spread import Travel, at_rows, vertical_shape
from rocsafe_geo.arrays import FloatArray

# Pairs of point and place worked on at once.
_BLOCK = 1_000_000
# Offsets of a plume that meanders, in standard deviations, and their weights (Gauss and Hermite).
_ROOTS, _SHARES = np.polynomial.hermite_e.hermegauss(5)
_WEIGHTS = np.asarray(_SHARES / _SHARES.sum())
# Farther beside a plume, in its crosswind standard deviations, there is nothing of it.
_REACH = 6.0
# Slower wind does not carry a plume anywhere: readings in it count as in this wind, m/s.
LEAST_SPEED_MPS = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class PlumeShape:
    """How a plume differs from the one that the air suggests.

    Attributes
    ----------
    spread_y, spread_z
        Factors of its crosswind and vertical size.
    turn_rad
        Angle by which the true wind is turned anticlockwise from the measured one, radians.
    meander
        Share of the crosswind variance that is meander: during one reading the plume is narrower
        and lies beside its mean.
    """

    spread_y: float = 1.0
    spread_z: float = 1.0
    turn_rad: float = 0.0
    meander: float = 0.6


def offset_weights(units: FloatArray) -> FloatArray:
    """Return the weights of the offsets of `unit_readings`, their first axis."""
    return _WEIGHTS if len(units) == len(_WEIGHTS) else np.ones(1)


def unit_readings(
    survey: GasSurvey,
    places_m: FloatArray,
    height_m: float,
    travel: Travel,
    reference_mps: float,
    shape: PlumeShape,
) -> FloatArray:
    """Return the readings for releases of 1 g/s, (offsets, n, m), s/m^3.

    The first axis is that of the offsets of a meandering plume, see `offset_weights`; a plume
    that does not meander has one.

    Parameters
    ----------
    survey
        Readings (n).
    places_m : (m, 2)
        East and north of the releases, metres.
    height_m
        Their height above the ground, metres.
    travel
        How a plume spreads in the mean wind.
    reference_mps
        The wind that `travel` is for at the height of the anemometer, m/s. The sizes of a plume
        do not depend on the speed in the same air; the concentration is inverse to it.
    shape
        How the plume differs.
    """
    count = len(survey.weights)
    offsets = len(_ROOTS) if shape.meander else 1
    found = np.empty((offsets, len(survey.values_g_m3), len(places_m)))
    size = max(_BLOCK // (len(places_m) * count), 1)
    for start in range(0, found.shape[1], size):
        own = slice(start, start + size)
        points = survey.places_m[own].reshape(-1, 3)
        winds = np.repeat(survey.wind_towards_mps[own], count, axis=0)
        values = _concentrations(points, winds, places_m, height_m, travel, shape)
        values = values.reshape(offsets, -1, count, len(places_m))
        found[:, own] = np.einsum('orkm,k->orm', values, survey.weights)
    speeds = np.maximum(survey.speeds_mps, LEAST_SPEED_MPS)
    return np.asarray(found * (reference_mps / speeds)[:, None])


def _concentrations(
    points_m: FloatArray,
    winds_mps: FloatArray,
    places_m: FloatArray,
    height_m: float,
    travel: Travel,
    shape: PlumeShape,
) -> FloatArray:
    """Return the concentrations at points (r, 3) of releases at places (m, 2), (offsets, r, m)."""
    angles = np.arctan2(winds_mps[:, 1], winds_mps[:, 0]) + shape.turn_rad
    east, north = np.cos(angles)[:, None], np.sin(angles)[:, None]
    first = points_m[:, :1] - places_m[:, 0]
    second = points_m[:, 1:2] - places_m[:, 1]
    along, across = first * east + second * north, second * east - first * north
    roots = _ROOTS.tolist() if shape.meander else [0.0]
    found = np.zeros((len(roots), *along.shape))
    row, column = np.nonzero(along > 0.0)
    rows = travel.rows(along[row, column])
    sigma_y = shape.spread_y * at_rows(travel.sigma_y_m, rows)
    ratio = across[row, column] / sigma_y
    is_near = np.abs(ratio) < _REACH
    row, column, rows = row[is_near], column[is_near], rows[is_near]
    sigma_y, ratio = sigma_y[is_near], ratio[is_near]
    sigma_z = shape.spread_z * at_rows(travel.sigma_z_m, rows)
    flow = at_rows(travel.airborne / travel.speeds_mps, rows)
    flow = flow * vertical_shape(points_m[row, 2], height_m, sigma_z)
    narrow = math.sqrt(1.0 - shape.meander)
    peak = flow / (math.sqrt(2.0 * math.pi) * narrow * sigma_y)
    for number, root in enumerate(roots):
        offset = (ratio - math.sqrt(shape.meander) * root) / narrow
        found[number, row, column] = peak * np.exp(-0.5 * offset**2)
    return found
