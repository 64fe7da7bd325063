# SPDX-License-Identifier: Apache-2.0
"""Heights above the ground of photographs whose tags hold only an altitude, or none.

Photographs that are tied to each other show how far apart the cameras are, over their height; the
fixes show it in metres. Altitudes then give the height of the ground.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.initial.initial_poses import initial_poses
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment.model.mark import MARK_STD_M, Mark
from rocsafe_mapping.alignment.model.photo import Photo
from rocsafe_mapping.alignment_options import InitialOptions

NORMAL_MAD = 1.4826


def with_heights(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    options: InitialOptions,
    marks: Sequence[Mark] = (),
) -> dict[str, Photo]:
    """Return the photographs without a height, each with the height that ties and anchors show.

    Anchors are fixes and surveyed marks. Empty if nothing shows it: too few photographs are tied,
    or the anchors are too near to each other.
    """
    known = [photo for photo in photos.values() if photo.has_height]
    levels = [photo.altitude_m - photo.prior.centre[2] for photo in known]
    heights = {photo.name: float(photo.prior.centre[2]) for photo in known}
    if not known:
        heights = _scaled_heights(photos, pairs, options, marks)
        levels = [photos[name].altitude_m - height for name, height in heights.items()]
    if not heights:
        return {}
    usual_m = float(np.median(list(heights.values())))
    ground_m, scatter_m = _centre(np.array([level for level in levels if math.isfinite(level)]))
    found = {}
    for name, photo in photos.items():
        if photo.has_height:
            continue
        height_m = heights.get(name, photo.altitude_m - ground_m)
        is_usable = scatter_m < options.altitude_share * usual_m and height_m > 0.0
        if name not in heights and not is_usable:
            height_m = usual_m
        # All these heights have the same error, that of the scale: as independent measurements
        # they would keep the adjustment from correcting it.
        std_m = options.found_height_share * height_m * math.sqrt(len(photos))
        found[name] = photo.with_height(height_m, std_m)
    return found


def _scaled_heights(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    options: InitialOptions,
    marks: Sequence[Mark],
) -> dict[str, float]:
    """Return the heights of the largest group of tied photographs, in the scale of its anchors."""
    first = initial_poses(photos, pairs, options, marks)
    if not first.groups:
        return {}
    names = first.groups[0]
    fixed = [photos[name] for name in names if photos[name].has_fix]
    places = [photo.prior.centre[:2] for photo in fixed]
    stds_m = [photo.horizontal_std_m for photo in fixed]
    for mark in marks:
        if set(mark.sightings) & set(names):
            places.append(mark.surveyed_m)
            stds_m.append(MARK_STD_M)
    if len(names) < 3 or len(places) < 2:
        return {}
    spread_m = np.linalg.norm(np.array(places) - np.median(places, axis=0), axis=1).max()
    if spread_m < options.least_baselines * float(np.median(stds_m)):
        return {}
    return {name: float(first.poses[name].centre[2]) for name in names}


def _centre(values: FloatArray) -> tuple[float, float]:
    """Return the median of some values and their robust standard deviation."""
    if not len(values):
        return math.nan, math.inf
    middle = float(np.median(values))
    return middle, NORMAL_MAD * float(np.median(np.abs(values - middle)))
