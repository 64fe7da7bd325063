# SPDX-License-Identifier: Apache-2.0
"""An adjustment of all photographs of a survey from the beginning, and laying one on another."""

import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment import initial
from rocsafe_mapping.alignment.adjustment import adjusted
from rocsafe_mapping.alignment.clocks import in_time, lags_s
from rocsafe_mapping.alignment.matching import Pair
from rocsafe_mapping.alignment.photo import Photo, Pose
from rocsafe_mapping.alignment.state import State


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """An adjustment of all photographs.

    Attributes
    ----------
    state: that fits best.
    unbelieved: photographs whose yaws are wrong alike.
    rejected: pairs that do not agree with the others.
    lags_s: by how much the fixes of vehicles are late, of those that surely are.
    """

    state: State
    unbelieved: frozenset[str]
    rejected: tuple[Pair, ...]
    lags_s: Mapping[str, float] = dataclasses.field(default_factory=dict)


def solved(photos: Mapping[str, Photo], pairs: Sequence[Pair]) -> Solution:
    """Return the adjustment of all photographs that `pairs` tie, from the beginning."""
    first = initial.start(photos, pairs)
    unbelieved = frozenset(
        name
        for names, is_believed in zip(first.groups, first.is_yaw_believed, strict=True)
        for name in names
        if not is_believed
    )
    kept = {id(pair) for pair in first.pairs}
    state = State(poses=first.poses)
    late: dict[str, float] = {}
    if first.poses:
        told = {name: without_yaw(photo, unbelieved) for name, photo in photos.items()}
        state = adjusted(_some(told, first.poses), first.pairs, state)
        late = lags_s(told, state.poses)
        if late:
            state = adjusted(_some(in_time(told, late), first.poses), first.pairs, state)
            late = lags_s(told, state.poses) or late
    return Solution(
        state=state,
        unbelieved=unbelieved,
        rejected=tuple(pair for pair in pairs if id(pair) not in kept),
        lags_s=late,
    )


def _some(photos: Mapping[str, Photo], names: Collection[str]) -> dict[str, Photo]:
    return {name: photos[name] for name in names}


def without_yaw(photo: Photo, unbelieved: frozenset[str]) -> Photo:
    """Return `photo`, its yaw without weight if it is one of the unbelieved."""
    if photo.name not in unbelieved:
        return photo
    return dataclasses.replace(photo, yaw_std_rad=math.pi)


def carried(
    loose: Mapping[str, Pose], placed: Mapping[str, Pose], name: str, near: set[str]
) -> Pose:
    """Return the pose of `name` when `loose` is laid on the poses of neighbours, if there are."""
    tied = sorted(near & set(loose))
    if not tied:
        return loose[name]
    turn = sum(
        (_plane_turn(placed[other].rotation @ loose[other].rotation.T) for other in tied), 0j
    )
    turn /= abs(turn)
    scale = float(np.median([placed[o].centre[2] / loose[o].centre[2] for o in tied]))
    start = np.mean([complex(*loose[o].centre[:2]) for o in tied])
    end = np.mean([complex(*placed[o].centre[:2]) for o in tied])
    place = end + turn * scale * (complex(*loose[name].centre[:2]) - start)
    about_up = np.array(
        [[turn.real, -turn.imag, 0.0], [turn.imag, turn.real, 0.0], [0.0, 0.0, 1.0]]
    )
    return Pose(
        centre=np.array([place.real, place.imag, scale * loose[name].centre[2]]),
        rotation=about_up @ loose[name].rotation,
    )


def _plane_turn(rotation: FloatArray) -> complex:
    """Return the turn about up of a rotation as a unit complex number."""
    turn = complex(rotation[0, 0] + rotation[1, 1], rotation[1, 0] - rotation[0, 1])
    return turn / max(abs(turn), 1e-12)
