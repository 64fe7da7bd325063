# SPDX-License-Identifier: Apache-2.0
"""How a cloud grows, moves and shrinks with the distance that it has travelled.

The law of similarity: sizes from friction velocity, Obukhov length and the measured scatter of
the wind direction, with the forms of Venkatram and others 2013 (Atmos. Environ. 77, 846) for the
height. Its numbers were fitted to the odd-numbered runs of Prairie Grass: docs/dispersion.md.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_dispersion.plume.briggs import Setting, briggs_sigmas_m
from rocsafe_dispersion.plume.losses import NO_LOSSES, REFERENCE_M, Losses
from rocsafe_dispersion.plume.rise import rise_m
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between, require_not_negative, require_positive
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.stability import StabilityClass

NEAREST_M, FARTHEST_M, ROWS = 0.1, 3e4, 480
# The law is one of the surface layer.
HIGHEST_M = 30.0
_RATIO = math.log(FARTHEST_M / NEAREST_M) / (ROWS - 1)
_ITERATIONS = 30
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(24)


@dataclass(frozen=True, slots=True, kw_only=True)
class SpreadOptions:
    """Numbers of the law of similarity.

    Attributes
    ----------
    vertical
        Vertical growth in neutral air: sigma_z = vertical u*/U x.
    stable
        How much stable air slows it down.
    unstable
        How much unstable air speeds it up.
    lagrangian_s
        Time scale of the crosswind turbulence, seconds.

    Notes
    -----
    `stable` and `unstable` are those of Venkatram and others 2013; `vertical` (there 0.57) and
    `lagrangian_s` were fitted to Prairie Grass, odd runs, together with the resistance of the
    ground to the tracer, 30 s/m.
    """

    vertical: float = 0.5
    stable: float = 3.0
    unstable: float = 1.5
    lagrangian_s: float = 20.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Travel:
    """A cloud after each of a row of distances, which grow by a constant ratio.

    Attributes
    ----------
    distances_m, sigma_y_m, sigma_z_m : (ROWS,)
        Distance travelled, crosswind and vertical standard deviation, metres.
    speeds_mps, times_s : (ROWS,)
        Speed of its middle, m/s: the wind averaged over the cloud; time travelled, seconds.
    airborne : (ROWS,)
        Share of what was released that is still in the air.
    fallen_m : (ROWS,)
        How far it has settled, metres; below 0 it has risen.
    wind_heights_m : (ROWS,)
        Height above the ground at which the wind has the speed of its middle, metres.
    height_m
        Height of the release above the ground, metres.
    """

    distances_m: FloatArray
    sigma_y_m: FloatArray
    sigma_z_m: FloatArray
    speeds_mps: FloatArray
    times_s: FloatArray
    airborne: FloatArray
    fallen_m: FloatArray
    wind_heights_m: FloatArray
    height_m: float

    def rows(self, distances_m: ArrayLike) -> FloatArray:
        """Return the rows of distances, fractions included."""
        near = np.clip(np.asarray(distances_m, float), NEAREST_M, FARTHEST_M * (1.0 - 1e-9))
        return np.asarray(np.log(near / NEAREST_M) / _RATIO)

    def at(self, distance_m: float) -> tuple[float, float, float, float, float]:
        """Return sigma_y, sigma_z (metres), speed (m/s), airborne and fallen (metres) there."""
        near = min(max(distance_m, NEAREST_M), FARTHEST_M * (1.0 - 1e-9))
        share, whole = math.modf(math.log(near / NEAREST_M) / _RATIO)
        row, rest = int(whole), 1.0 - share
        sigma_y, sigma_z, speed, airborne, fallen = (
            column.item(row) * rest + column.item(row + 1) * share
            for column in (
                self.sigma_y_m, self.sigma_z_m, self.speeds_mps, self.airborne, self.fallen_m,
            )
        )  # fmt: skip
        return sigma_y, sigma_z, speed, airborne, fallen

    def heights_m(self) -> FloatArray:
        """Return the height of its middle above the ground, (ROWS,), metres."""
        return np.maximum(self.height_m - self.fallen_m, 0.0)


def at_rows(column: FloatArray, rows: FloatArray) -> FloatArray:
    """Return a column of a table between its rows."""
    whole = rows.astype(int)
    share = rows - whole
    return np.asarray(column[whole] * (1.0 - share) + column[whole + 1] * share)


def similarity_travel(
    layer: SurfaceLayer,
    height_m: float,
    *,
    sigma_theta_rad: float | None = None,
    start_sigma_m: float = 0.0,
    buoyancy_m4_s3: float = 0.0,
    losses: Losses = NO_LOSSES,
    options: SpreadOptions | None = None,
) -> Travel:
    """Return how a cloud from near the ground travels in a surface layer.

    Parameters
    ----------
    layer
        The air.
    height_m
        Height of the release above the ground, at most 30 m: the law is one of the surface layer.
    sigma_theta_rad
        Standard deviation of the wind direction near the ground over 10 minutes, radians; None:
        from the layer.
    start_sigma_m
        Size of the release, metres.
    buoyancy_m4_s3
        Flux of buoyancy by which it rises (`rocsafe_dispersion.plume.rise`), m^4/s^3.
    losses
        What takes it out of the air.
    options
        Numbers of the law.

    Raises
    ------
    ValueError
        If a value is out of range, or it rises above the surface layer.
    """
    options = options or SpreadOptions()
    require_between('height_m', height_m, 0.0, HIGHEST_M, 'm')
    require_not_negative('start_sigma_m', start_sigma_m, 'm')
    distances = NEAREST_M * np.exp(_RATIO * np.arange(ROWS))
    risen = rise_m(distances, buoyancy_m4_s3, layer)
    require_between('height to which it rises', height_m + float(risen[-1]), 0.0, HIGHEST_M, 'm')
    sigma_z, speeds = _vertical(layer, distances, height_m + risen, start_sigma_m, options)
    if sigma_theta_rad is None:
        sigma_theta_rad = layer.sigma_v_mps() / float(layer.speed_mps(10.0))
    require_between('sigma_theta_rad', sigma_theta_rad, 0.0, 1.5, 'rad')
    slow = np.sqrt(1.0 + distances / (2.0 * speeds * options.lagrangian_s))
    sigma_y = np.hypot(sigma_theta_rad * distances / slow, start_sigma_m)
    return _travel(distances, (sigma_y, sigma_z), speeds, height_m, layer, losses, risen)


def briggs_travel(
    stability: StabilityClass,
    layer: SurfaceLayer,
    height_m: float,
    *,
    setting: Setting = 'rural',
    speed_height_m: float = 10.0,
    losses: Losses = NO_LOSSES,
) -> Travel:
    """Return how a cloud travels by the curves of Briggs, with the wind at one height."""
    require_positive('speed_height_m', speed_height_m, 'm')
    distances = NEAREST_M * np.exp(_RATIO * np.arange(ROWS))
    sigmas = briggs_sigmas_m(distances, stability, setting)
    speeds = np.full(ROWS, float(layer.speed_mps(speed_height_m)))
    return _travel(distances, sigmas, speeds, height_m, layer, losses, np.zeros(ROWS))


def _vertical(
    layer: SurfaceLayer,
    distances: FloatArray,
    heights_m: FloatArray,
    start_m: float,
    options: SpreadOptions,
) -> tuple[FloatArray, FloatArray]:
    """Return vertical size and mean wind; each depends on the other."""
    sigma = np.hypot(0.05 * distances, start_m)
    speeds = np.ones_like(sigma)
    friction, length = layer.friction_velocity_mps, layer.obukhov_length_m
    for _ in range(_ITERATIONS):
        speeds = mean_speeds_mps(layer, heights_m, sigma)
        grown = options.vertical * friction / speeds * distances
        if length > 0.0:
            ratio = (distances / length) ** (2.0 / 3.0)
            grown = grown / (1.0 + options.stable * friction / speeds * ratio)
        else:
            grown = grown * (1.0 + options.unstable * friction / speeds * distances / -length)
        # The geometric mean of the last two keeps the iteration from swinging.
        sigma = np.sqrt(sigma * np.hypot(grown, start_m))
    return sigma, speeds


def mean_speeds_mps(layer: SurfaceLayer, heights_m: FloatArray, sigma_m: FloatArray) -> FloatArray:
    """Return the wind averaged over vertical Gaussian clouds with reflection, of their shape."""
    low = np.maximum(heights_m - 5.0 * sigma_m, 0.0)
    high = heights_m + 5.0 * sigma_m
    heights = low[:, None] + (high - low)[:, None] * (_NODES + 1.0) / 2.0
    weights = vertical_shape(heights, heights_m[:, None], sigma_m[:, None]) * _WEIGHTS
    return np.asarray((weights * layer.speed_mps(heights)).sum(axis=1) / weights.sum(axis=1))


def vertical_shape(heights_m: FloatArray, middle_m: ArrayLike, sigma_m: ArrayLike) -> FloatArray:
    """Return the share of a cloud per metre of height, 1/m; the ground reflects it."""
    sigma, middle = np.asarray(sigma_m, float), np.asarray(middle_m, float)
    down = np.exp(-0.5 * ((heights_m - middle) / sigma) ** 2)
    up = np.exp(-0.5 * ((heights_m + middle) / sigma) ** 2)
    return np.asarray((down + up) / (math.sqrt(2.0 * math.pi) * sigma))


def _travel(
    distances: FloatArray,
    sigmas: tuple[FloatArray, FloatArray],
    speeds: FloatArray,
    height_m: float,
    layer: SurfaceLayer,
    losses: Losses,
    risen_m: FloatArray,
) -> Travel:
    steps = np.diff(distances, prepend=0.0)
    times = np.cumsum(steps / speeds)
    fallen = np.minimum(losses.settling_mps * times - risen_m, height_m)
    # Share a metre that the ground takes: v_d times the concentration over it, per unit of flow.
    shape = vertical_shape(np.full(ROWS, REFERENCE_M), height_m - fallen, sigmas[1])
    taken = losses.deposition_mps(layer) * shape / speeds
    middle = (taken + np.concatenate([taken[:1], taken[:-1]])) / 2.0
    kept = np.exp(-np.cumsum(middle * steps) - losses.decay_per_s * times)
    levels = np.geomspace(2.0 * layer.roughness_m, 2000.0, 400)
    return Travel(
        distances_m=distances,
        sigma_y_m=sigmas[0],
        sigma_z_m=sigmas[1],
        speeds_mps=speeds,
        times_s=times,
        airborne=kept,
        fallen_m=fallen,
        wind_heights_m=np.interp(speeds, layer.speed_mps(levels), levels),
        height_m=height_m,
    )
