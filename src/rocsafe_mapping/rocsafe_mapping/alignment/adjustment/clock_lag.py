# SPDX-License-Identifier: Apache-2.0
"""Clock lags: vehicles whose fixes are late or early beside their photographs.

Where a camera's clock is late, each fix is off by the lag times the velocity: forwards on one
strip, backwards on the next. The poses from the ties show it. No lag is found for a vehicle that
stops for each photograph, or that flies in one direction only: there it cannot be told from a
shift of all fixes.
"""

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_mapping.alignment.model.photo import Photo, Pose
from rocsafe_mapping.alignment_options import ClockOptions

# Standard deviation of a normal distribution over its median absolute deviation.
NORMAL_MAD = 1.4826


@dataclass(frozen=True, slots=True, kw_only=True)
class Velocity:
    """How fast a vehicle moved when it took a photograph.

    Attributes
    ----------
    mean_mps
        (east, north) to and from the photograph, shape (2,).
    spread_mps
        Half of what the two differ by.
    is_straight
        Whether they go the same way.
    """

    mean_mps: FloatArray
    spread_mps: float
    is_straight: bool


def velocities(photos: Mapping[str, Photo], straight_cosine: float) -> dict[str, Velocity]:
    """Return the velocities at photographs, from the fixes of the ones before and after."""
    by_vehicle: dict[str, list[Photo]] = {}
    for photo in sorted(photos.values(), key=lambda photo: (photo.time_ns, photo.name)):
        if not photo.has_fix:
            continue
        by_vehicle.setdefault(photo.vehicle, []).append(photo)
    found = {}
    for flown in by_vehicle.values():
        for number, photo in enumerate(flown):
            near = flown[max(number - 1, 0) : number + 2]
            legs = [
                leg for first, second in itertools.pairwise(near)
                if (leg := _leg_mps(first, second)) is not None
            ]  # fmt: skip
            if legs:
                found[photo.name] = _velocity(legs, straight_cosine)
    return found


def _leg_mps(first: Photo, second: Photo) -> FloatArray | None:
    took_s = (second.time_ns - first.time_ns) / NS_PER_S
    if took_s <= 0.0:
        return None
    leg: FloatArray = (second.prior.centre - first.prior.centre)[:2] / took_s
    return leg


def _velocity(legs: Sequence[FloatArray], straight_cosine: float) -> Velocity:
    first, last = legs[0], legs[-1]
    speeds = float(np.linalg.norm(first) * np.linalg.norm(last))
    return Velocity(
        mean_mps=0.5 * (first + last),
        spread_mps=0.5 * float(np.linalg.norm(first - last)),
        is_straight=float(first @ last) > straight_cosine * speeds > 0.0,
    )


def lags_s(
    photos: Mapping[str, Photo], poses: Mapping[str, Pose], options: ClockOptions
) -> dict[str, float]:
    """Return the lags of vehicles whose fixes are certainly late, seconds.

    Parameters
    ----------
    photos
        With their fixes as measured.
    poses
        Of those of them that are tied.
    """
    speeds = velocities(photos, options.straight_cosine)
    rows: dict[str, list[tuple[FloatArray, FloatArray]]] = {}
    for name, velocity in sorted(speeds.items()):
        is_fast = np.linalg.norm(velocity.mean_mps) > options.least_speed_mps
        if name in poses and velocity.is_straight and is_fast:
            off = (photos[name].prior.centre - poses[name].centre)[:2]
            rows.setdefault(photos[name].vehicle, []).append((off, velocity.mean_mps))
    found = {
        vehicle: _lag_s(some, options)
        for vehicle, some in rows.items()
        if len(some) >= options.least_photos
    }
    return {vehicle: lag for vehicle, lag in found.items() if lag}


def _lag_s(rows: Sequence[tuple[FloatArray, FloatArray]], options: ClockOptions) -> float:
    """Return the lag from `rows` of (error of the fix, velocity), 0 if none is certain."""
    off = np.concatenate([row[0] for row in rows])
    along = np.concatenate([row[1] for row in rows])
    # A shift that all fixes have in common is not a lag.
    axes = np.tile(np.eye(2), (len(rows), 1))
    plain, _ = _fitted(axes, off, options)
    found, variance = _fitted(np.column_stack([axes, along]), off, options)
    lag, std = float(found[2]), math.sqrt(max(float(variance[2, 2]), 0.0))
    # Means, not medians: half of the values, those across the path, do not change.
    before = float(np.mean(np.abs(off - axes @ plain)))
    after = float(np.mean(np.abs(off - np.column_stack([axes, along]) @ found)))
    is_certain = options.certainty * std < abs(lag) < options.largest_lag_s
    return lag if is_certain and after < options.left_share * before else 0.0


def _fitted(
    design: FloatArray, values: FloatArray, options: ClockOptions
) -> tuple[FloatArray, FloatArray]:
    """Return the robust fit of `values` and its covariance."""
    weight: FloatArray = np.ones(len(values))
    for _ in range(options.rounds):
        normal = np.asarray(np.linalg.pinv(design.T @ (weight[:, np.newaxis] * design)), float)
        found = normal @ (design.T @ (weight * values))
        left = values - design @ found
        scale = max(NORMAL_MAD * float(np.median(np.abs(left))), 1e-6)
        weight = 1.0 / (1.0 + (left / (options.knee * scale)) ** 2)
    freedom = max(float(weight.sum()) - design.shape[1], 1.0)
    return found, normal * (float(np.sum(weight * left**2)) / freedom)


def without_lag(
    photos: Mapping[str, Photo], lags: Mapping[str, float], options: ClockOptions
) -> dict[str, Photo]:
    """Return `photos` with the lag of the fixes corrected.

    Where the path turns, the velocity is uncertain, and so is the corrected fix.
    """
    if not lags:
        return dict(photos)
    speeds, moved = velocities(photos, options.straight_cosine), dict(photos)
    for name, photo in photos.items():
        lag = lags.get(photo.vehicle, 0.0)
        if lag and name in speeds:
            back = np.array([*(-lag * speeds[name].mean_mps), 0.0])
            moved[name] = dataclasses.replace(
                photo,
                prior=Pose(centre=photo.prior.centre + back, rotation=photo.prior.rotation),
                horizontal_std_m=math.hypot(photo.horizontal_std_m, lag * speeds[name].spread_mps),
            )
    return moved
