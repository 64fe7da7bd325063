# SPDX-License-Identifier: Apache-2.0
"""Bundle adjustment: poses, points and one lens, by Levenberg-Marquardt with a Schur complement.

Triggs, McLauchlan, Hartley, Fitzgibbon: Bundle adjustment - a modern synthesis (1999).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bsr_matrix, csr_matrix, hstack

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.projection import (
    LENS_SIZE,
    POSE_SIZE,
    Views,
    sighting_derivatives,
    sighting_residuals,
)
from rocsafe_mapping.alignment.adjustment.rotation import turned
from rocsafe_mapping.alignment_options import StructureOptions

Index = NDArray[np.int64]
POINT_SIZE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    """Photographs with their poses, and points.

    Attributes
    ----------
    centres, rotations
        Of the cameras, shape (n, 3) and (n, 3, 3) from the optical frame to the scene.
    points
        Shape (m, 3).
    lens
        Logarithm of the focal length over the believed one, k1, k2; see `projection`.
    """

    centres: FloatArray
    rotations: FloatArray
    points: FloatArray
    lens: FloatArray

    def moved(self, cameras: FloatArray, points: FloatArray) -> 'Scene':
        """Return the scene after steps of cameras with the lens behind, and of points (m, 3)."""
        steps = cameras[:-LENS_SIZE].reshape(-1, POSE_SIZE)
        rotations = [turned(step[3:]) @ r for step, r in zip(steps, self.rotations, strict=True)]
        return replace(
            self,
            centres=self.centres + steps[:, :3],
            rotations=np.array(rotations),
            points=self.points + points,
            lens=self.lens + cameras[-LENS_SIZE:],
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Observations:
    """Which photograph shows which point where.

    Attributes
    ----------
    photos, points
        Indices, shape (n,).
    offsets_px
        Pixels less the principal point, shape (n, 2).
    focal_px
        Believed focal length of each sighting, shape (n,).
    """

    photos: Index
    points: Index
    offsets_px: FloatArray
    focal_px: FloatArray

    def views(self, scene: Scene) -> Views:
        """Return the cameras of the sightings."""
        return Views(
            offsets_px=self.offsets_px,
            focal_px=self.focal_px * np.exp(scene.lens[0]),
            radial=np.broadcast_to(scene.lens[1:], (len(self.photos), 2)),
            centres=scene.centres[self.photos],
            rotations=scene.rotations[self.photos],
        )

    def errors_px(self, scene: Scene) -> FloatArray:
        """Return how far points are seen from where they were sighted, infinite behind, (n,)."""
        moved = sighting_residuals(self.views(scene), scene.points[self.points])
        ahead = scene.points[self.points] - scene.centres[self.photos]
        depth = np.einsum('nj,nj->n', scene.rotations[self.photos][:, :, 2], ahead)
        return np.where(depth > 0.0, np.linalg.norm(moved.residuals_px, axis=1), np.inf)

    def subset(self, chosen: NDArray[np.bool_]) -> 'Observations':
        """Return some of them."""
        return Observations(
            photos=self.photos[chosen],
            points=self.points[chosen],
            offsets_px=self.offsets_px[chosen],
            focal_px=self.focal_px[chosen],
        )


def bundled(
    scene: Scene, seen: Observations, options: StructureOptions, lens_std: FloatArray
) -> Scene:
    """Return the scene that fits best; the first camera is held.

    `lens_std` (3,) is the prior of the lens; 0 holds it. Points that lie behind a camera are not
    seen by it: one such sighting, almost infinitely wrong, would outweigh all others.
    """
    seen = seen.subset(np.isfinite(seen.errors_px(scene)))
    damping = options.first_damping
    cost = _cost(scene, seen, options, lens_std)
    for _ in range(options.bundle_steps):
        system = _system(scene, seen, options, lens_std)
        cameras, points = _step(system, damping)
        moved = scene.moved(cameras, points)
        after = _cost(moved, seen, options, lens_std)
        if after < cost:
            gain, scene, cost = cost - after, moved, after
            damping = max(0.1 * damping, 1e-8)
            if gain < options.least_gain * cost:
                break
        else:
            damping *= 30.0
            if damping > options.largest_damping:
                break
    return scene


def _cost(
    scene: Scene, seen: Observations, options: StructureOptions, lens_std: FloatArray
) -> float:
    moved = sighting_residuals(seen.views(scene), scene.points[seen.points])
    square = np.sum(moved.residuals_px**2, axis=1) / options.knee_px**2
    free = lens_std > 0.0
    prior = np.sum((scene.lens[free] / lens_std[free]) ** 2)
    return float(np.sum(2.0 * (np.sqrt(1.0 + square) - 1.0)) * options.knee_px**2 + prior)


@dataclass(frozen=True, slots=True, kw_only=True)
class _System:
    """Normal equations: cameras with the lens behind, points, and what couples them."""

    cameras: FloatArray
    points: FloatArray
    coupling: csr_matrix
    camera_right: FloatArray
    point_right: FloatArray


def _system(
    scene: Scene, seen: Observations, options: StructureOptions, lens_std: FloatArray
) -> _System:
    moved = sighting_derivatives(seen.views(scene), scene.points[seen.points])
    square = np.sum(moved.residuals.residuals_px**2, axis=1) / options.knee_px**2
    trust = ((1.0 + square) ** -0.25)[:, np.newaxis]
    residual = moved.residuals.residuals_px * trust
    by_pose, by_point, by_lens = (
        part * trust[:, :, np.newaxis]
        for part in (moved.second_pose, moved.first_pose, moved.second_lens)
    )
    # The first camera is held, and a lens without uncertainty.
    by_pose[seen.photos == 0] = 0.0
    by_lens[:, :, lens_std == 0.0] = 0.0
    size = POSE_SIZE * len(scene.centres)
    jacobian = hstack([
        _block_column(by_pose, seen.photos, size),
        csr_matrix(by_lens.reshape(-1, LENS_SIZE)),
    ]).tocsr()  # fmt: skip
    point_jacobian = _block_column(by_point, seen.points, POINT_SIZE * len(scene.points))
    blocks = np.zeros((len(scene.points), POINT_SIZE, POINT_SIZE))
    np.add.at(blocks, seen.points, np.einsum('nij,nik->njk', by_point, by_point))
    jacobian.eliminate_zeros()
    cameras = (jacobian.T @ jacobian).toarray()
    prior = np.where(lens_std > 0.0, np.maximum(lens_std, 1e-9) ** -2.0, 0.0)
    at = size + np.arange(LENS_SIZE)
    cameras[at, at] += prior
    right = -(jacobian.T @ residual.ravel())
    right[at] -= prior * scene.lens
    return _System(
        cameras=cameras,
        points=blocks,
        coupling=(jacobian.T @ point_jacobian).tocsr(),
        camera_right=right,
        point_right=-(point_jacobian.T @ residual.ravel()),
    )


def _block_column(blocks: FloatArray, index: Index, width: int) -> csr_matrix:
    """Return a sparse matrix of blocks (n, 2, k), two rows each, the k columns from k `index`."""
    count, lines, size = blocks.shape
    columns = np.repeat(size * index[:, np.newaxis] + np.arange(size), lines, axis=0)
    starts = size * np.arange(lines * count + 1)
    return csr_matrix((blocks.ravel(), columns.ravel(), starts), shape=(lines * count, width))


def _step(system: _System, damping: float) -> tuple[FloatArray, FloatArray]:
    """Return the steps of cameras with the lens, and of points (m, 3)."""
    cameras, points = system.cameras.copy(), system.points.copy()
    at = np.arange(len(cameras))
    # Values that are held fixed add no information.
    cameras[at, at] += damping * cameras[at, at] + 1e-9 + (cameras[at, at] == 0.0)
    diagonal = np.arange(POINT_SIZE)
    points[:, diagonal, diagonal] *= 1.0 + damping
    points[:, diagonal, diagonal] += 1e-9
    inverse = np.linalg.inv(points)
    count = len(points)
    blocks = bsr_matrix(
        (inverse, np.arange(count), np.arange(count + 1)),
        shape=(POINT_SIZE * count, POINT_SIZE * count),
    )
    weighted = system.coupling @ blocks.tocsr()
    reduced = cameras - (weighted @ system.coupling.T).toarray()
    right = system.camera_right - weighted @ system.point_right
    step = np.linalg.solve(reduced, right)
    rest = (system.point_right - system.coupling.T @ step).reshape(-1, POINT_SIZE)
    return step, np.einsum('nij,nj->ni', inverse, rest)
