# SPDX-License-Identifier: Apache-2.0
"""Fixes of photographs from the track of their vehicle and the times of exposure.

The clock of a camera differs from that of a receiver, often by hours. The offset is where the
track, at the times of the photographs, has the shape that their ties give them.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_mapping.alignment.initial.initial_poses import initial_poses
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment.model.photo import Photo
from rocsafe_mapping.alignment_options import InitialOptions, PathOptions
from rocsafe_mapping.errors import PlacementError


@dataclass(frozen=True, slots=True, kw_only=True)
class FlownPath:
    """Places of a vehicle over time.

    Attributes
    ----------
    times_s
        Seconds since 1970 UTC, shape (n,), increasing.
    places_m
        East, north and altitude above the origin of the local frame, shape (n, 3).
    """

    times_s: FloatArray
    places_m: FloatArray

    def at(self, times_s: FloatArray) -> FloatArray:
        """Return the places (k, 3) at times (k,), NaN before and after the track."""
        columns = [
            np.interp(times_s, self.times_s, column, left=np.nan, right=np.nan)
            for column in self.places_m.T
        ]
        return np.column_stack(columns)

    def speeds_mps(self, times_s: FloatArray, step_s: float) -> FloatArray:
        """Return the speeds over the ground (k,) about times (k,)."""
        legs = self.at(times_s + step_s) - self.at(times_s - step_s)
        speeds: FloatArray = np.nan_to_num(np.linalg.norm(legs[:, :2], axis=1)) / (2.0 * step_s)
        return speeds


def fixed_by_path(
    photos: Mapping[str, Photo], path: FlownPath, offset_s: float, options: PathOptions
) -> dict[str, Photo]:
    """Return the photographs without a fix that the track covers, with the fix that it gives.

    `offset_s` is what the camera's clock is behind the track's.
    """
    names = sorted(name for name, photo in photos.items() if not photo.has_fix)
    times_s = _times_s(photos, names) + offset_s
    places, speeds = path.at(times_s), path.speeds_mps(times_s, options.exposure_std_s)
    found = {}
    for name, place, speed in zip(names, places, speeds, strict=True):
        if np.isfinite(place[0]):
            std_m = math.hypot(options.horizontal_std_m, speed * options.exposure_std_s)
            found[name] = dataclasses.replace(
                photos[name].at(place[:2], std_m), altitude_m=float(place[2])
            )
    return found


def clock_offset_s(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    path: FlownPath,
    initial: InitialOptions,
    options: PathOptions,
) -> float:
    """Return by how many seconds the camera's clock is behind the track's.

    Raises
    ------
    PlacementError
        If no offset fits, or several fit alike.
    """
    first = initial_poses(photos, pairs, initial)
    names = [name for name in (first.groups or ((),))[0] if not photos[name].has_fix]
    if len(names) < options.least_photos:
        raise PlacementError(
            f'{len(names)} photographs without a fix are tied to each other, fewer than '
            f'{options.least_photos}: the track cannot be laid on them; give --clock-offset'
        )
    times_s = _times_s(photos, names)
    shape = np.array([complex(*first.poses[name].centre[:2]) for name in names])
    low = path.times_s[0] - times_s.max() + (1.0 - options.least_share) * np.ptp(times_s)
    high = path.times_s[-1] - times_s.min() - (1.0 - options.least_share) * np.ptp(times_s)
    step_s = max(options.step_s, (high - low) / options.most_steps)
    offsets = np.arange(low, high + step_s, step_s) if high >= low else np.zeros(0)

    def misfit(offset_s: float) -> float:
        return _misfit(offset_s, path, times_s, shape, options)

    misfits = np.array([misfit(offset) for offset in offsets])
    tried = []
    for offset in _lowest(offsets, misfits, options):
        near = (offset - step_s, offset + step_s)
        fit = minimize_scalar(misfit, bounds=near, method='bounded')
        tried.append((float(fit.fun), float(fit.x)))
    return _only_good(sorted(tried), options)


def _lowest(offsets: FloatArray, misfits: FloatArray, options: PathOptions) -> list[float]:
    """Return the offsets of a few of the lowest misfits that are not neighbours of each other."""
    chosen: list[float] = []
    for offset in offsets[np.argsort(misfits)]:
        if all(abs(offset - other) > options.same_s for other in chosen):
            chosen.append(float(offset))
        if len(chosen) == options.candidates:
            break
    return chosen


def _only_good(tried: Sequence[tuple[float, float]], options: PathOptions) -> float:
    """Return the offset of least misfit of (misfit, offset), lowest first.

    Raises
    ------
    PlacementError
        If none is good, or several are.
    """
    if not tried or tried[0][0] > options.largest_misfit:
        raise PlacementError(
            'the track has nowhere the shape of the photographs: is it of this flight? '
            'Give --clock-offset if it is'
        )
    best = tried[0][1]
    if len(tried) > 1 and tried[1][0] < options.rival_factor * tried[0][0]:
        raise PlacementError(
            f'clock offsets of {best:.0f} s and {tried[1][1]:.0f} s fit the track alike: '
            'give --clock-offset'
        )
    return best


def _misfit(
    offset_s: float,
    path: FlownPath,
    times_s: FloatArray,
    shape: FloatArray,
    options: PathOptions,
) -> float:
    """Return what a similarity leaves of the track at the times, over its spread."""
    places = path.at(times_s + offset_s)
    track = places[:, 0] + 1j * places[:, 1]
    inside = np.isfinite(track)
    if inside.mean() < options.least_share:
        return 1.0
    wanted = track[inside] - track[inside].mean()
    spread = shape[inside] - shape[inside].mean()
    size = float(np.sum(np.abs(wanted) ** 2))
    if size < len(wanted) * options.least_spread_m**2:
        return 1.0
    alike = abs(np.vdot(spread, wanted)) ** 2 / (float(np.sum(np.abs(spread) ** 2)) * size)
    return math.sqrt(max(1.0 - alike, 0.0))


def _times_s(photos: Mapping[str, Photo], names: Sequence[str]) -> FloatArray:
    return np.array([photos[name].time_ns / NS_PER_S for name in names])
