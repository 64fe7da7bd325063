# SPDX-License-Identifier: Apache-2.0
"""The block: all photographs of a map, their pairs and their poses, while they come in.

A photograph is first placed by its fix, then matched with its neighbours and adjusted with them
while all others are held. From time to time, and at the end, all photographs are adjusted
together from the beginning: that result depends on the set of photographs alone.
"""

import dataclasses
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_mapping.alignment.adjustment.clock_lag import without_lag
from rocsafe_mapping.alignment.adjustment.least_squares import adjusted
from rocsafe_mapping.alignment.initial.flown_path import FlownPath, clock_offset_s, fixed_by_path
from rocsafe_mapping.alignment.initial.flying_height import with_heights
from rocsafe_mapping.alignment.initial.initial_poses import initial_poses
from rocsafe_mapping.alignment.initial.location import locate
from rocsafe_mapping.alignment.initial.pair_graph import groups_of
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment.matching.pair_table import PairTable, ReadGray
from rocsafe_mapping.alignment.model.mark import Mark
from rocsafe_mapping.alignment.model.photo import Photo, Pose
from rocsafe_mapping.alignment.model.state import State
from rocsafe_mapping.alignment.steps import (
    Solution,
    find_pairs,
    pose_beside,
    solve_block,
    without_yaw,
)
from rocsafe_mapping.alignment.structure.step import find_structure
from rocsafe_mapping.alignment_options import AlignmentOptions
from rocsafe_mapping.errors import PlacementError

BY_FEATURES, BY_GPS = 'features', 'gps'


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """Place of a photograph in the map, and the data that put it there.

    Attributes
    ----------
    pose
        Of its camera.
    placed_by
        ``features`` when tied to others, ``gps`` when only its own measurements place it.
    """

    pose: Pose
    placed_by: str


class Block:
    """All photographs, their pairs and their poses.

    Parameters
    ----------
    read_gray
        Returns the grey picture of a photograph by name.
    options
        Of the alignment.
    """

    def __init__(self, read_gray: ReadGray, options: AlignmentOptions) -> None:
        self.options = options
        self.pair_table = PairTable(read_gray, options)
        self._photos: dict[str, Photo] = {}
        self._unbelieved: frozenset[str] = frozenset()
        self.lags_s: Mapping[str, float] = {}
        self._rejected: set[tuple[str, str]] = set()
        self.state = State(poses={})
        self.marks: tuple[Mark, ...] = ()
        self.path: FlownPath | None = None
        self.clock_offset_s = math.nan
        self.is_local = False
        self._scenes: tuple[Mapping[str, Pose], ...] = ()

    def __len__(self) -> int:
        return len(self._photos)

    def __contains__(self, name: str) -> bool:
        return name in self._photos

    @property
    def photos(self) -> Mapping[str, Photo]:
        """The photographs by name; wrong yaws have no weight, late fixes are corrected."""
        photos = {name: self.photo(name) for name in self._photos}
        return without_lag(photos, self.lags_s, self.options.clock)

    @property
    def used_pairs(self) -> tuple[Pair, ...]:
        """Pairs that agree with the others, both photographs placed by features."""
        placed = self.state.poses
        return tuple(
            pair
            for key, pair in self.pair_table.found.items()
            if key not in self._rejected and placed.keys() >= set(key)
        )

    def add(self, photo: Photo) -> None:
        """Take in a photograph, placed by its fix."""
        self._photos[photo.name] = photo
        self.pair_table.add(photo)

    def find_pairs(self) -> tuple[str, ...]:
        """Match all photographs that may overlap; unknown places and heights are found first.

        Returns
        -------
        tuple
            Names of the photographs that nothing places, which are forgotten.

        Raises
        ------
        PlacementError
            If heights above the ground are unknown and cannot be found.
        """
        self._follow_path(())
        if all(photo.has_height and photo.is_located for photo in self._photos.values()):
            find_pairs(self.pair_table)
            return ()
        self.pair_table.match_nearest()
        is_oblique = self._find_tilts()
        pairs = tuple(self.pair_table.found.values())
        self._follow_path(pairs)
        lost = self._locate(pairs)
        self._find_heights(pairs)
        if not is_oblique:
            find_pairs(self.pair_table)
        return lost

    def _find_tilts(self) -> bool:
        """Find how photographs look where too few are tied as if they looked down.

        Returns whether that was necessary and possible.
        """
        options = self.options.structure
        pairs = tuple(self.pair_table.found.values())
        groups = [len(group) for group in groups_of(pairs)]
        tied, tied_in_one = sum(groups), max(groups, default=0)
        count = len(self._photos)
        level = sum(
            p.tilt_std_rad < self.options.prior.tilt_std_rad for p in self._photos.values()
        )
        if (
            tied_in_one >= options.least_tied_share * count
            or 2 * level > count
            or not 2 < count <= options.most_photos
        ):
            return False
        found = find_structure(self._photos, self.pair_table.read_gray, self.options)
        if found is None:
            return False
        if (len(found.photos), max(map(len, found.scenes))) <= (tied, tied_in_one):
            return False
        for photo in found.photos.values():
            self.replace(photo)
        self.pair_table.adopt(found.pairs)
        self._scenes = found.scenes
        return True

    def _follow_path(self, pairs: Sequence[Pair]) -> None:
        """Give photographs the fixes of the track, if the offset of their clock is known.

        From `pairs`, where there are any, it is found.
        """
        if self.path is None or all(photo.has_fix for photo in self._photos.values()):
            return
        options = self.options
        if math.isnan(self.clock_offset_s):
            if not pairs:
                return
            self.clock_offset_s = clock_offset_s(
                self._photos, pairs, self.path, options.initial, options.path
            )
        found = fixed_by_path(self._photos, self.path, self.clock_offset_s, options.path)
        for photo in found.values():
            self.replace(photo)

    def _locate(self, pairs: Sequence[Pair]) -> tuple[str, ...]:
        """Find where photographs without a fix were taken; forget those that nothing places."""
        if all(photo.is_located for photo in self._photos.values()):
            return ()
        found = locate(self._photos, pairs, self.marks, self.options.initial)
        self.is_local = found.is_local
        for name in found.lost:
            self.remove(name)
        for photo in found.photos.values():
            self.replace(photo)
        return found.lost

    def _find_heights(self, pairs: Sequence[Pair]) -> None:
        if all(photo.has_height for photo in self._photos.values()):
            return
        pairs = [pair for pair in pairs if self._photos.keys() >= {pair.first, pair.second}]
        found = with_heights(self._photos, pairs, self.options.initial, self.marks)
        if not found:
            raise PlacementError(
                'no photograph tells its height above the ground, and too few overlap to '
                'find it from their fixes'
            )
        for photo in found.values():
            self.replace(photo)

    def replace(self, photo: Photo) -> None:
        """Take over a new prior of a photograph."""
        self._photos[photo.name] = photo
        self.pair_table.replace(photo)

    def remove(self, name: str) -> None:
        """Forget a photograph, which is not placed among others."""
        del self._photos[name]
        self.pair_table.remove(name)

    def photo(self, name: str) -> Photo:
        """Return a photograph with the fix that it was given; a wrong yaw has no weight."""
        return without_yaw(self._photos[name], self._unbelieved)

    def place(self, name: str) -> frozenset[str]:
        """Adjust a tied photograph with its neighbours; return the names of those that moved."""
        partners = self.pair_table.partners(name)
        if not partners:
            return frozenset()
        placed = partners & set(self.state.poses)
        fresh = ({name} | partners) - placed
        near = fresh | placed
        found = self.pair_table.found
        pairs = [pair for key, pair in found.items() if near >= set(key)]
        first = initial_poses(self._photos, pairs, self.options.initial)
        poses = dict(self.state.poses)
        for other in sorted(fresh & set(first.poses)):
            # The first poses lie anywhere: only their shape is used, beside known poses.
            poses[other] = pose_beside(first.poses, poses, other, placed)
        free = near & set(poses)
        pairs = [
            pair
            for key, pair in found.items()
            if key not in self._rejected and free & set(key) and poses.keys() >= set(key)
        ]
        state = dataclasses.replace(self.state, poses=poses)
        self.state = adjusted(self.photos, pairs, state, self.options, free)
        return frozenset(free)

    def place_all(self) -> None:
        """Adjust all photographs from the beginning."""
        self.adopt(self.global_solution()())

    def global_solution(self) -> Callable[[], Solution]:
        """Return the adjustment of all photographs, to be carried out, also by another thread."""
        photos, pairs = dict(self._photos), tuple(self.pair_table.found.values())
        marks = self.marks
        return lambda: solve_block(photos, pairs, self.options, marks)

    def adopt(self, solution: Solution) -> None:
        """Take over a solution; photographs that came since keep their place among the others."""
        before = self.state
        self._unbelieved, self.lags_s = solution.unbelieved, solution.lags_s
        self._rejected = {
            key for key, pair in self.pair_table.found.items() if pair in solution.rejected
        }
        self.state = solution.state
        for name in sorted(before.poses.keys() - solution.state.poses.keys()):
            self.place(name)

    def placements(self, names: Collection[str] | None = None) -> dict[str, Placement]:
        """Return where every photograph is, or some of them."""
        return {
            name: Placement(pose=self.state.poses[name], placed_by=BY_FEATURES)
            if name in self.state.poses
            else self._untied(name)
            for name in (self._photos if names is None else names)
        }

    def _untied(self, name: str) -> Placement:
        """Return where a photograph without ties is.

        One that structure from motion placed, but that shows no ground nearby, lies beside those
        that are tied, if its fix does not contradict that.
        """
        options = self.options.structure
        loose = next((scene for scene in self._scenes if name in scene), {})
        tied = sorted(loose.keys() & self.state.poses.keys())
        if len(tied) < options.beside:
            return Placement(pose=self._corrected(name), placed_by=BY_GPS)
        away = [float(np.linalg.norm(loose[other].centre - loose[name].centre)) for other in tied]
        near = {tied[at] for at in np.argsort(away)[: options.beside]}
        pose, photo = pose_beside(loose, self.state.poses, name, near), self._photos[name]
        off_m = float(np.linalg.norm((pose.centre - photo.prior.centre)[:2]))
        std_m = photo.horizontal_std_m * max(self.state.noise.fix_factor, 1.0)
        if photo.has_fix and off_m > options.largest_off_stds * std_m:
            return Placement(pose=self._corrected(name), placed_by=BY_GPS)
        return Placement(pose=pose, placed_by=BY_FEATURES)

    def _corrected(self, name: str) -> Pose:
        """Return the prior pose, moved as the fixes of tied photographs nearby were wrong.

        A height that is hardly known becomes that of those photographs.
        """
        options = self.options.adjustment
        photo = self._photos[name]
        prior = photo.prior
        offs = []
        for other, pose in self.state.poses.items():
            fix = self._photos[other].prior.centre
            away = float(np.linalg.norm(fix[:2] - prior.centre[:2]))
            if self._photos[other].has_fix and away < options.correcting_reach * prior.centre[2]:
                offs.append((away, other, pose.centre - [*fix[:2], 0.0]))
        if len(offs) < options.correcting_fixes:
            return prior
        nearest = sorted(offs, key=lambda off: off[:2])[: options.correcting_fixes]
        east, north, height_m = np.median([off for _, _, off in nearest], axis=0)
        if photo.vertical_std_m < self.options.initial.guessed_height_share * prior.centre[2]:
            height_m = prior.centre[2] + self.state.lifts_m.get(photo.vehicle, 0.0)
        centre = np.array([prior.centre[0] + east, prior.centre[1] + north, height_m])
        return Pose(centre=centre, rotation=prior.rotation)
