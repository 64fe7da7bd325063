# SPDX-License-Identifier: Apache-2.0
"""The alignment of a survey while its photographs come in.

Each photograph is first believed where its fix puts it, then tied to its neighbours and adjusted
together with them, everything around held. From time to time, and at the end, all photographs
are adjusted together from the beginning: that result depends on the set of photographs alone.
"""

import dataclasses
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

import numpy as np

from rocsafe_mapping.alignment import initial
from rocsafe_mapping.alignment.adjustment import adjusted
from rocsafe_mapping.alignment.clocks import in_time
from rocsafe_mapping.alignment.features import Features, Gray, orb_features, sift_features
from rocsafe_mapping.alignment.initial import Start
from rocsafe_mapping.alignment.matching import Pair, View, match
from rocsafe_mapping.alignment.neighbours import Neighbourhood
from rocsafe_mapping.alignment.photo import Photo, Pose
from rocsafe_mapping.alignment.solution import Solution, carried, solved, without_yaw
from rocsafe_mapping.alignment.state import State

FEATURES = 1500
# A photograph with fewer partners than this is worth the dearer features.
FEW_PARTNERS = 2
# Neighbours whose residuals correct one that nothing ties.
CORRECTING = 4
CORRECTING_REACH = 3.0
BY_FEATURES, BY_GPS = 'features', 'gps'
ReadGray = Callable[[str], Gray]


@dataclass(frozen=True, slots=True, kw_only=True)
class Placement:
    """Where a photograph was put, and by what.

    Attributes
    ----------
    pose: of its camera.
    placed_by: ``features`` when tied to others, ``gps`` when only its own measurements place it.
    """

    pose: Pose
    placed_by: str


class Survey:
    """All photographs, their ties and their poses.

    Parameters
    ----------
    read_gray: returns the grey picture of a photograph by name.
    """

    def __init__(self, read_gray: ReadGray) -> None:
        self._read_gray = read_gray
        self._photos: dict[str, Photo] = {}
        self._features: dict[str, Features] = {}
        self._sift: dict[str, Features] = {}
        self._neighbours = Neighbourhood()
        self._pairs: dict[tuple[str, str], Pair | None] = {}
        self._sift_tried: set[tuple[str, str]] = set()
        self._unbelieved: frozenset[str] = frozenset()
        self.lags_s: Mapping[str, float] = {}
        self._rejected: set[tuple[str, str]] = set()
        self.state = State(poses={})

    def __len__(self) -> int:
        return len(self._photos)

    def __contains__(self, name: str) -> bool:
        return name in self._photos

    @property
    def photos(self) -> Mapping[str, Photo]:
        """The photographs by name, what was found to be wrong of them made good.

        Wrong yaws are without weight, late fixes are brought back.
        """
        photos = {name: self._believed(photo) for name, photo in self._photos.items()}
        return in_time(photos, self.lags_s)

    @property
    def pairs(self) -> tuple[Pair, ...]:
        """Pairs found so far, in order of their names."""
        return tuple(pair for _, pair in sorted(self._pairs.items()) if pair is not None)

    @property
    def used_pairs(self) -> tuple[Pair, ...]:
        """Pairs that agree with the others, both photographs placed by features."""
        placed = self.state.poses
        return tuple(
            pair
            for key, pair in sorted(self._pairs.items())
            if pair is not None and key not in self._rejected and placed.keys() >= set(key)
        )

    def add(self, photo: Photo) -> None:
        """Take in a photograph, which lies where its fix says."""
        self._photos[photo.name] = photo
        self._neighbours.add(photo)

    def remove(self, name: str) -> None:
        """Forget a photograph that was added but never tied."""
        del self._photos[name]
        self._neighbours.remove(name)

    def photo(self, name: str) -> Photo:
        """Return a photograph."""
        return self._believed(self._photos[name])

    def waiting(self) -> tuple[str, ...]:
        """Return the names of the photographs whose features are not known yet."""
        return tuple(sorted(set(self._photos) - set(self._features)))

    def extract(self, name: str) -> None:
        """Find the features of a photograph. Raises what reading it raises."""
        self._features[name] = orb_features(self._read_gray(name), FEATURES)

    def tie(self, name: str) -> int:
        """Tie a photograph to those of its neighbours that are there; return to how many."""
        if name not in self._features:
            self.extract(name)
        ties = 0
        for other in self._neighbours.of(name):
            if other in self._features:
                ties += self._match(*sorted((name, other))) is not None
        return ties

    def place(self, name: str) -> frozenset[str]:
        """Adjust a tied photograph with its neighbours; return the names of those that moved."""
        partners = self._partners(name)
        if not partners:
            return frozenset()
        placed = partners & set(self.state.poses)
        fresh = ({name} | partners) - placed
        first = self._start(fresh | placed)
        poses = dict(self.state.poses)
        for other in sorted(fresh & set(first.poses)):
            # A start is loose: only its shape is taken, laid on poses that are known.
            poses[other] = carried(first.poses, poses, other, placed)
        free = (fresh | placed) & set(poses)
        pairs = [
            pair
            for key, pair in sorted(self._pairs.items())
            if pair and key not in self._rejected and free & set(key) and poses.keys() >= set(key)
        ]
        state = dataclasses.replace(self.state, poses=poses)
        self.state = adjusted(self.photos, pairs, state, free)
        return frozenset(free)

    def place_all(self) -> frozenset[str]:
        """Adjust all photographs from the beginning; return the names of those that are tied."""
        self.adopt(self.global_solution()())
        return frozenset(self.state.poses)

    def global_solution(self) -> Callable[[], Solution]:
        """Return the adjustment of all photographs, to be carried out, also by another thread."""
        photos, pairs = dict(self._photos), self.pairs
        return lambda: solved(photos, pairs)

    def adopt(self, solution: Solution) -> None:
        """Take over a solution; photographs that came since keep their place among the others."""
        before = self.state
        self._unbelieved, self.lags_s = solution.unbelieved, solution.lags_s
        self._rejected = {
            (pair.first, pair.second) for pair in self.pairs if pair in solution.rejected
        }
        self.state = solution.state
        for name in sorted(before.poses.keys() - solution.state.poses.keys()):
            self.place(name)

    def complete(self) -> None:
        """Look for all pairs that the full set of photographs suggests, hardest for the lonely."""
        for name in self.waiting():
            self.extract(name)
        wanted = self._neighbours.pairs()
        for pair in wanted:
            self._match(*pair)
        # Pairs that only an early arrival suggested do not count: order shall not matter.
        self._pairs = {key: pair for key, pair in self._pairs.items() if key in set(wanted)}
        weak = {name for name in self._photos if len(self._partners(name)) < FEW_PARTNERS}
        for pair in wanted:
            if self._pairs[pair] is None and pair not in self._sift_tried and weak & set(pair):
                self._sift_tried.add(pair)
                self._pairs[pair] = self._match_sift(*pair)

    def placements(self, names: Collection[str] | None = None) -> dict[str, Placement]:
        """Return where every photograph is, or some of them."""
        return {
            name: Placement(pose=self.state.poses[name], placed_by=BY_FEATURES)
            if name in self.state.poses
            else Placement(pose=self._corrected(name), placed_by=BY_GPS)
            for name in (self._photos if names is None else names)
        }

    def _believed(self, photo: Photo) -> Photo:
        return without_yaw(photo, self._unbelieved)

    def _partners(self, name: str) -> set[str]:
        found = set()
        for (first, second), pair in self._pairs.items():
            if pair is not None and name in (first, second):
                found |= {first, second}
        return found - {name}

    def _start(self, names: set[str] | None) -> Start:
        """Return first poses of all photographs, or of some."""
        pairs = [
            p for p in self.pairs if names is None or (p.first in names and p.second in names)
        ]
        return initial.start(self._photos, pairs)

    def _match(self, first: str, second: str) -> Pair | None:
        key = (first, second)
        if key not in self._pairs:
            self._pairs[key] = match(self._view(first), self._view(second), 'orb')
        return self._pairs[key]

    def _match_sift(self, first: str, second: str) -> Pair | None:
        for name in (first, second):
            if name not in self._sift:
                self._sift[name] = sift_features(self._read_gray(name), FEATURES)
        views = [
            dataclasses.replace(self._view(name), features=self._sift[name])
            for name in (first, second)
        ]
        return match(views[0], views[1], 'sift')

    def _view(self, name: str) -> View:
        return View(
            photo=self._photos[name],
            features=self._features[name],
            gray=lambda: self._read_gray(name),
        )

    def _corrected(self, name: str) -> Pose:
        """Return the prior pose, moved as the fixes of tied photographs nearby were wrong."""
        photo = self._photos[name]
        offs = []
        for other, pose in self.state.poses.items():
            prior = self._photos[other].prior.centre
            away = float(np.linalg.norm(prior[:2] - photo.prior.centre[:2]))
            if away < CORRECTING_REACH * photo.prior.centre[2]:
                offs.append((away, other, pose.centre[:2] - prior[:2]))
        if len(offs) < CORRECTING:
            return photo.prior
        nearest = sorted(offs, key=lambda off: off[:2])[:CORRECTING]
        shift = np.median([off for _, _, off in nearest], axis=0)
        centre = photo.prior.centre + np.array([*shift, 0.0])
        return Pose(centre=centre, rotation=photo.prior.rotation)
