# SPDX-License-Identifier: Apache-2.0
"""Places of photographs without a fix: beside those that have one, or on a local map.

Ties put them beside each other. Fixes of others and surveyed marks put them on the earth; without
any, two photographs become the base line of a local map, which has neither scale nor north.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.initial.initial_poses import InitialPoses, initial_poses
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment.model.mark import Mark
from rocsafe_mapping.alignment.model.photo import Photo
from rocsafe_mapping.alignment_options import InitialOptions

BASE_STD_SHARE = 1e-4
"""Uncertainty of the ends of the base line, which defines the local map, over the height."""
LEAST_ANCHORS = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Located:
    """Photographs found without a fix.

    Attributes
    ----------
    photos
        With the place that was found, by name.
    lost
        Names of those that nothing ties to the others.
    is_local
        Whether the map has neither scale nor north.
    """

    photos: Mapping[str, Photo]
    lost: tuple[str, ...]
    is_local: bool


def locate(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    marks: Sequence[Mark],
    options: InitialOptions,
) -> Located:
    """Return where the photographs without a fix were taken."""
    first = initial_poses(photos, pairs, options, marks)
    lost = {name for name, photo in photos.items() if not photo.is_located}
    is_local = not any(photo.has_fix for photo in photos.values()) and not any(
        count >= LEAST_ANCHORS for count in first.anchors
    )
    found: dict[str, Photo] = {}
    for number, names in enumerate(first.groups):
        if first.anchors[number] < LEAST_ANCHORS and not (is_local and number == 0):
            continue
        for name in sorted(lost & set(names)):
            found[name] = photos[name].at(first.poses[name].centre[:2], np.inf)
    if is_local and first.groups:
        found |= _base_line(found, first)
    return Located(photos=found, lost=tuple(sorted(lost - set(found))), is_local=is_local)


def _base_line(found: Mapping[str, Photo], first: InitialPoses) -> dict[str, Photo]:
    """Return the two photographs that are farthest from each other, more or less, as fixed."""
    names = first.groups[0]
    places: FloatArray = np.array([first.poses[name].centre[:2] for name in names])
    one = int(np.argmax(np.linalg.norm(places - places.mean(axis=0), axis=1)))
    other = int(np.argmax(np.linalg.norm(places - places[one], axis=1)))
    height_m = float(np.median([first.poses[name].centre[2] for name in names]))
    return {
        names[at]: found[names[at]].at(places[at], BASE_STD_SHARE * height_m)
        for at in (one, other)
    }
