# SPDX-License-Identifier: Apache-2.0
"""The steps of the alignment, in order: from photographs with priors to poses that fit.

Two functions are the method: `find_pairs` (steps 1 to 4) and `solve_block` (steps 5 to 9). The
constants of each step stand under its name in `rocsafe_mapping.alignment_options`.
"""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.clock_lag import lags_s, without_lag
from rocsafe_mapping.alignment.adjustment.least_squares import adjusted
from rocsafe_mapping.alignment.initial.initial_poses import initial_poses
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment.matching.pair_table import PairTable
from rocsafe_mapping.alignment.model.mark import Mark
from rocsafe_mapping.alignment.model.photo import Photo, Pose
from rocsafe_mapping.alignment.model.state import State
from rocsafe_mapping.alignment_options import AlignmentOptions


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """An adjustment of all photographs.

    Attributes
    ----------
    state
        That fits best.
    unbelieved
        Photographs whose yaws are all wrong by the same angle.
    rejected
        Pairs that do not agree with the others.
    lags_s
        By how much the fixes of vehicles are late, where that is certain.
    """

    state: State
    unbelieved: frozenset[str]
    rejected: tuple[Pair, ...]
    lags_s: Mapping[str, float] = dataclasses.field(default_factory=dict)


def find_pairs(table: PairTable) -> tuple[Pair, ...]:
    """Return the pairs of photographs that certainly show the same ground.

    1. Features (`matching.features`): ORB points, spread over each photograph.
    2. Neighbours (`matching.neighbours`): photographs whose footprints overlap, by their priors.
    3. Matches (`matching.pair_matching`): a homography from the strongest features, then guided
       matches of all; verified by number, spread, scale, tilt and, in doubt, the fixes.
    4. Ties (`matching.refinement`, `matching.parallax`): exact to a fraction of a pixel, with the
       points that stand off the plane; a fifth is held out. SIFT where ORB found too few pairs.
    """
    table.match_all()
    return tuple(table.found.values())


def solve_block(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    options: AlignmentOptions,
    marks: Sequence[Mark] = (),
) -> Solution:
    """Return the adjustment of all photographs that `pairs` tie, from the beginning.

    Surveyed `marks` hold it beside the fixes.
    """
    # 5. Graph of pairs (`initial.pair_graph`): groups that hang together; pairs that contradict
    #    the loops which they close are rejected.
    # 6. First poses (`initial.initial_poses`): turns and heights, then places, near the fixes.
    first = initial_poses(photos, pairs, options.initial, marks)
    unbelieved = frozenset(
        name
        for names, is_believed in zip(first.groups, first.is_yaw_believed, strict=True)
        for name in names
        if not is_believed
    )
    sighted = tuple(mark for mark in marks if first.poses.keys() & set(mark.sightings))
    state, lags = State(poses=first.poses, marks=sighted), {}
    if first.poses:
        # 7. Adjustment (`adjustment.least_squares`): poses and lenses from ties and priors.
        # 8. Ground heights (`model.surface`): where the ties show that the ground is not level.
        told = {name: without_yaw(photos[name], unbelieved) for name in first.poses}
        state = adjusted(told, first.pairs, state, options)
        # 9. Clock lags (`adjustment.clock_lag`): fixes that are late are corrected, and 7 and 8
        #    done again.
        everyone = {name: without_yaw(photo, unbelieved) for name, photo in photos.items()}
        lags = lags_s(everyone, state.poses, options.clock)
        if lags:
            corrected = without_lag(everyone, lags, options.clock)
            told = {name: corrected[name] for name in first.poses}
            state = adjusted(told, first.pairs, state, options)
            lags = lags_s(everyone, state.poses, options.clock) or lags
    kept = {id(pair) for pair in first.pairs}
    return Solution(
        state=state,
        unbelieved=unbelieved,
        rejected=tuple(pair for pair in pairs if id(pair) not in kept),
        lags_s=lags,
    )


def without_yaw(photo: Photo, unbelieved: frozenset[str]) -> Photo:
    """Return `photo`, its yaw without weight if it is one of the unbelieved."""
    if photo.name not in unbelieved:
        return photo
    return dataclasses.replace(photo, yaw_std_rad=math.pi)


def pose_beside(
    loose: Mapping[str, Pose], placed: Mapping[str, Pose], name: str, near: set[str]
) -> Pose:
    """Return the pose that a photograph has beside its neighbours.

    Parameters
    ----------
    loose
        Poses of the photograph and its neighbours that fit each other, but lie anywhere.
    placed
        Poses where they belong.
    name
        Of the photograph.
    near
        Its neighbours that are in `placed`; without one the pose stays as it is in `loose`.
    """
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
