# SPDX-License-Identifier: Apache-2.0
"""A scene that grows by one photograph after the other (incremental structure from motion).

Snavely, Seitz, Szeliski: Photo tourism (2006); Schoenberger, Frahm: Structure-from-motion
revisited (2016).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.structure.bundle import Observations, Scene, bundled
from rocsafe_mapping.alignment.structure.epipolar import Key, Link, Tracks
from rocsafe_mapping.alignment_options import StructureOptions

NOWHERE = -1
HELD = np.zeros(3)


@dataclass(frozen=True, slots=True, kw_only=True)
class Grown:
    """What became of some photographs.

    Attributes
    ----------
    names
        Indices of the photographs that have a pose, in the order of the scene.
    scene
        Their poses and points.
    seen
        Sightings that agree with it; its points are those of the scene.
    tracks
        Index of the track of each point of the scene.
    """

    names: tuple[int, ...]
    scene: Scene
    seen: Observations
    tracks: NDArray[np.int64]

    def common_points(self, key: Key) -> int:
        """Return how many points two photographs have in common; 0 if one has no pose."""
        if not set(key) <= set(self.names):
            return 0
        first, second = (self.seen.photos == self.names.index(name) for name in key)
        return len(np.intersect1d(self.seen.points[first], self.seen.points[second]))


@dataclass(frozen=True, slots=True)
class Cameras:
    """What saw the points.

    Attributes
    ----------
    offsets_px
        Pixels less the principal point of the features of each photograph, (n, 2).
    focal_px
        Of each photograph.
    lens_std
        Prior of logarithm of the focal length, k1 and k2; zeros for a calibrated camera.
    """

    offsets_px: Sequence[FloatArray]
    focal_px: FloatArray
    lens_std: FloatArray


def all_grown(
    links: Mapping[Key, Link], tracks: Tracks, cameras: Cameras, options: StructureOptions
) -> tuple[Grown, ...]:
    """Return scenes without common photographs, that of most sightings first.

    Photographs that too little ties to those of a scene form one of their own, with a lens of its
    own: few photographs tell little of the lens, and with that of another scene nothing may grow.
    """
    left, found = dict(links), []
    while (grown := best_grown(left, tracks, cameras, options)) is not None:
        found.append(grown)
        left = {key: link for key, link in left.items() if not set(grown.names) & set(key)}
    return tuple(found)


def best_grown(
    links: Mapping[Key, Link], tracks: Tracks, cameras: Cameras, options: StructureOptions
) -> Grown | None:
    """Return the scene in which most sightings agree, of those of several seeds; None without any.

    Two photographs may agree by a wrong geometry, of a plane above all: the scene that grows from
    them takes in most photographs, but fewer of their sightings. From a seed of whose matches most
    agree with a scene, the same scene would grow: it is passed over. Pairs that are no seed do not
    count, or a few of them would hide all others.
    """
    found: list[Grown] = []
    tried = 0
    for key in _seeds(links, options):
        if tried == options.seeds:
            break
        if any(2 * scene.common_points(key) > len(links[key].matches) for scene in found):
            tried += 1
            continue
        scene = Growth(tracks, cameras, options).grow(key, links[key])
        if scene is not None:
            found.append(scene)
            tried += 1
    return max(found, key=lambda scene: len(scene.seen.photos), default=None)


class Growth:
    """Grows a scene from two photographs."""

    def __init__(self, tracks: Tracks, cameras: Cameras, options: StructureOptions) -> None:
        self._options = options
        self._lens_std = cameras.lens_std
        offsets_px, focal_px = cameras.offsets_px, cameras.focal_px
        self._focal = focal_px
        self._photo, self._point = tracks.photos, tracks.points
        self._px = np.array(
            [offsets_px[p][f] for p, f in zip(tracks.photos, tracks.features, strict=True)]
        )
        # Sightings of each photograph: all of them are too many to be searched for each pair.
        starts = np.searchsorted(self._photo, np.arange(1, len(focal_px)))
        self._rows = np.split(np.arange(len(self._photo)), starts)
        self._good = np.ones(len(self._photo), bool)
        self._order: list[int] = []
        self._centres = np.zeros((len(focal_px), 3))
        self._rotations = np.zeros((len(focal_px), 3, 3))
        self._places = np.full((tracks.count, 3), np.nan)
        self._lens: FloatArray = np.zeros(3)
        self._bundled_count = 0

    def grow(self, key: Key, link: Link) -> Grown | None:
        """Return the largest scene that grows from two photographs; None if they are no seed.

        The lens is held until the end: a scene of few photographs makes up a lens that hides what
        is wrong with it.
        """
        if not self._begin(key, link):
            return None
        failed: dict[int, int] = {}
        while True:
            name = self._next(failed)
            if name is None:
                break
            if self._add(name):
                failed.pop(name, None)
                self._triangulate(name)
                if len(self._order) >= self._options.growth * self._bundled_count + 1:
                    self._bundle()
            else:
                # It is tried again when there are more points.
                failed[name] = self._known(name)
        for _ in range(2):
            self._bundle(self._lens_std)
        return self._grown()

    def _begin(self, key: Key, link: Link) -> bool:
        first, second = key
        self._order = [first, second]
        self._places[:] = np.nan
        self._rotations[first], self._centres[first] = np.eye(3), 0.0
        # x2 = R x1 + t: the second camera's axes in the first one's frame are R^T.
        self._rotations[second] = link.rotation.T
        self._centres[second] = -link.rotation.T @ link.direction
        self._triangulate(second)
        if int(np.isfinite(self._places[:, 0]).sum()) < self._options.least_seed_points:
            return False
        self._bundle()
        return int(np.isfinite(self._places[:, 0]).sum()) >= self._options.least_seed_points

    def _next(self, failed: Mapping[int, int]) -> int | None:
        """Return the photograph that shows most known points and was not tried with as many."""
        known = np.isfinite(self._places[self._point, 0])
        counts = np.bincount(self._photo[known], minlength=len(self._focal))
        counts[self._order] = 0
        for name, tried in failed.items():
            if counts[name] < 1.2 * tried + 5:
                counts[name] = 0
        best = int(np.argmax(counts))
        return best if counts[best] >= self._options.least_seen else None

    def _known(self, name: int) -> int:
        return int(np.count_nonzero(self._is_known(self._rows[name])))

    def _is_known(self, rows: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return whether the points of sightings have a place."""
        return np.isfinite(self._places[self._point[rows], 0])

    def _straight(self, rows: NDArray[np.int64]) -> FloatArray:
        """Return the undistorted rays x / z, y / z of sightings."""
        focal = self._focal[self._photo[rows]] * np.exp(self._lens[0])
        bent = self._px[rows] / focal[:, np.newaxis]
        square = np.sum(bent**2, axis=1, keepdims=True)
        rays: FloatArray = bent * (1.0 + self._lens[1] * square + self._lens[2] * square**2)
        return rays

    def _add(self, name: int) -> bool:
        """Find the pose of a photograph from points that it shows; return whether it is good."""
        options = self._options
        rows = self._rows[name]
        rows = rows[self._is_known(rows)]
        points, rays = self._places[self._point[rows]], self._straight(rows)
        # By the size of the errors, not by the number below a limit: of points near a plane two
        # poses may lie below it.
        ransac = cv2.UsacParams()
        ransac.threshold = options.pose_px / self._focal[name]
        ransac.score = cv2.SCORE_METHOD_MSAC
        ransac.maxIterations, ransac.confidence = 3000, 0.9999
        ransac.loMethod = cv2.LOCAL_OPTIM_INNER_LO
        ransac.randomGeneratorState = 0
        try:
            found, _, turn, shift, inside = cv2.solvePnPRansac(
                points, rays, np.eye(3), np.zeros(4), params=ransac
            )
        except cv2.error:
            return False
        if not found or inside is None or len(inside) < options.least_seen:
            return False
        if len(inside) < options.least_pose_share * len(points):
            return False
        inside = inside.ravel()
        turn, shift = cv2.solvePnPRefineLM(
            points[inside], rays[inside], np.eye(3), None, turn, shift
        )
        matrix = np.asarray(cv2.Rodrigues(turn)[0], float)
        self._rotations[name], self._centres[name] = matrix.T, -matrix.T @ shift.ravel()
        self._order.append(name)
        return True

    def _triangulate(self, name: int) -> None:
        """Find the points that a photograph and others in the scene show."""
        mine = self._unknown(name)
        row_of = np.full(len(self._places), NOWHERE)
        row_of[self._point[mine]] = mine
        for other in self._order:
            if other == name:
                continue
            theirs = self._unknown(other)
            theirs = theirs[row_of[self._point[theirs]] != NOWHERE]
            if len(theirs):
                self._intersect(name, other, row_of[self._point[theirs]], theirs)

    def _unknown(self, name: int) -> NDArray[np.int64]:
        """Return the good sightings of a photograph whose points have no place yet."""
        rows = self._rows[name]
        return rows[self._good[rows] & ~self._is_known(rows)]

    def _intersect(
        self, name: int, other: int, mine: NDArray[np.int64], theirs: NDArray[np.int64]
    ) -> None:
        """Take over points where the rays of two photographs meet well."""
        one, two = self._directions(name, mine), self._directions(other, theirs)
        cosine = np.sum(one * two, axis=1)
        base = self._centres[other] - self._centres[name]
        # The middle of the shortest line between the rays.
        sine2 = np.maximum(1.0 - cosine**2, 1e-12)
        near = (one @ base - cosine * (two @ base)) / sine2
        far = (cosine * (one @ base) - two @ base) / sine2
        place = 0.5 * (self._centres[name] + one * near[:, np.newaxis])
        place += 0.5 * (self._centres[other] + two * far[:, np.newaxis])
        good = (near > 0.0) & (far > 0.0)
        good &= np.arccos(np.clip(cosine, -1.0, 1.0)) > self._options.least_angle_rad
        for at, pose in ((mine, name), (theirs, other)):
            good &= self._errors(at, pose, place) < self._options.point_px
        self._places[self._point[mine[good]]] = place[good]

    def _directions(self, name: int, rows: NDArray[np.int64]) -> FloatArray:
        rays = self._straight(rows)
        rays = np.column_stack([rays, np.ones(len(rays))]) @ self._rotations[name].T
        directions: FloatArray = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        return directions

    def _errors(self, rows: NDArray[np.int64], name: int, places: FloatArray) -> FloatArray:
        seen = self._observed(rows, np.full(len(rows), name), np.arange(len(rows)))
        scene = Scene(
            centres=self._centres, rotations=self._rotations, points=places, lens=self._lens
        )
        return seen.errors_px(scene)

    def _observed(
        self, rows: NDArray[np.int64], photos: NDArray[np.int64], points: NDArray[np.int64]
    ) -> Observations:
        return Observations(
            photos=photos,
            points=points,
            offsets_px=self._px[rows],
            focal_px=self._focal[self._photo[rows]],
        )

    def _in_scene(self) -> tuple[NDArray[np.int64], Observations, NDArray[np.int64]]:
        """Return rows of the sightings in the scene, these, and the tracks of its points."""
        slot = np.full(len(self._focal), NOWHERE)
        slot[self._order] = np.arange(len(self._order))
        used = (slot[self._photo] != NOWHERE) & self._good
        used &= np.isfinite(self._places[self._point, 0])
        tracks, points = np.unique(self._point[used], return_inverse=True)
        rows = np.flatnonzero(used)
        return rows, self._observed(rows, slot[self._photo[rows]], points), tracks

    def _bundle(self, lens_std: FloatArray = HELD) -> None:
        """Adjust the scene, leave out sightings that disagree, and try points again."""
        rows, seen, tracks = self._in_scene()
        order = np.array(self._order)
        scene = Scene(
            centres=self._centres[order],
            rotations=self._rotations[order],
            points=self._places[tracks],
            lens=self._lens,
        )
        scene = bundled(scene, seen, self._options, lens_std)
        self._centres[order], self._rotations[order] = scene.centres, scene.rotations
        self._lens = scene.lens
        self._places[tracks] = scene.points
        bad = seen.errors_px(scene) > self._options.point_px
        self._good[rows[bad]] = False
        left = np.bincount(self._point[rows[~bad]], minlength=len(self._places))
        self._places[left < 2] = np.nan
        self._bundled_count = len(order)
        for name in self._order:
            self._triangulate(name)

    def _grown(self) -> Grown:
        _, seen, tracks = self._in_scene()
        order = np.array(self._order)
        scene = Scene(
            centres=self._centres[order],
            rotations=self._rotations[order],
            points=self._places[tracks],
            lens=self._lens,
        )
        return Grown(names=tuple(self._order), scene=scene, seen=seen, tracks=tracks)


def _seeds(links: Mapping[Key, Link], options: StructureOptions) -> list[Key]:
    """Return pairs to begin with: many matches under a good angle first."""

    def worth(key: Key) -> float:
        link = links[key]
        good = min(link.angle_rad / options.good_angle_rad, 1.0)
        return -len(link.matches) * (good if link.angle_rad < options.widest_rad else 0.1)

    return sorted(links, key=lambda key: (worth(key), key))
