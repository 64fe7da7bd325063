# SPDX-License-Identifier: Apache-2.0
"""Projection of a pixel of one photograph, by the ground, into another, with derivatives.

With a camera at c, its rotation R, a ray v = ((u - u0) / f, (v - v0) / f, 1) of a pixel, the
direction is d = R v, the ground point at the height z is g = c + t d with t = (c_z - z) / -d_z,
and its image in another camera is f w_xy / w_z with w = R'^T (g - c').

A rotation changes by R <- exp([w]x) R with a small vector w about east, north and up. Lenses are
straightened by v (1 + k1 r^2 + k2 r^4), r^2 = v_x^2 + v_y^2, whose coefficients start at 0.
"""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray

POSE_SIZE = 6
LENS_SIZE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Views:
    """One end of n ties: the pixels and the cameras that saw them.

    Attributes
    ----------
    offsets_px
        Pixels less the principal point, shape (n, 2).
    focal_px
        Shape (n,).
    radial
        k1 and k2, shape (n, 2).
    centres
        Shape (n, 3).
    rotations
        Shape (n, 3, 3).
    """

    offsets_px: FloatArray
    focal_px: FloatArray
    radial: FloatArray
    centres: FloatArray
    rotations: FloatArray

    def straightened(self) -> tuple[FloatArray, FloatArray]:
        """Return the rays' x and y without distortion (n, 2), and with it (n, 2)."""
        bent = self.offsets_px / self.focal_px[:, np.newaxis]
        square = np.sum(bent**2, axis=1)
        stretch = 1.0 + self.radial[:, 0] * square + self.radial[:, 1] * square**2
        return bent * stretch[:, np.newaxis], bent


@dataclass(frozen=True, slots=True, kw_only=True)
class TieResiduals:
    """Residuals of n ties in pixels of the second photograph.

    Attributes
    ----------
    residuals_px
        Where the first photograph's pixel is projected to, less where it was matched, (n, 2).
    ground_m
        (east, north) of the ties, (n, 2).
    height
        Derivatives to the ground's height, pixels a metre, (n, 2).
    """

    residuals_px: FloatArray
    ground_m: FloatArray
    height: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class TieDerivatives:
    """Residuals of n ties and their derivatives.

    Attributes
    ----------
    residuals
        Of the ties.
    first_pose, second_pose
        Derivatives to centre and rotation, (n, 2, 6).
    first_lens, second_lens
        Derivatives to log focal length, k1, k2, (n, 2, 3).
    """

    residuals: TieResiduals
    first_pose: FloatArray
    second_pose: FloatArray
    first_lens: FloatArray
    second_lens: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class _Rays:
    """Rays of the first photograph.

    Attributes
    ----------
    directions, drop
        East, north, up (n, 3), and how far down that is (n,).
    slope
        How far over the ground they get for each metre down, (n, 2).
    """

    directions: FloatArray
    drop: FloatArray
    slope: FloatArray


def grounded(first: Views, heights_m: FloatArray) -> FloatArray:
    """Return where the pixels of `first` meet ground at `heights_m` (n,): (n, 2)."""
    return _met(first, _rays(first), heights_m)


def tie_residuals(first: Views, second: Views, heights_m: FloatArray) -> TieResiduals:
    """Project the ties' pixels of `first`, on ground at `heights_m` (n,), into `second`."""
    return _residuals(first, second, _rays(first), heights_m)[0]


def tie_derivatives(first: Views, second: Views, heights_m: FloatArray) -> TieDerivatives:
    """Carry the ties' pixels from `first` over ground at `heights_m` (n,) into `second`."""
    rays = _rays(first)
    moved, seen, by_point = _residuals(first, second, rays, heights_m)
    reach = first.centres[:, 2] - heights_m
    # Ground to the first camera: g moves by [I | slope] dc and by t [I | slope] dd.
    eye = np.broadcast_to(np.eye(2), (len(reach), 2, 2))
    lever = np.concatenate([eye, rays.slope[:, :, None]], 2)
    by_direction = lever * (reach / rays.drop)[:, np.newaxis, np.newaxis]
    point = np.column_stack([moved.ground_m, heights_m])
    by_ground = by_point[:, :, :2]
    turning = by_direction @ -_cross(rays.directions)
    by_ray = (by_ground @ by_direction @ first.rotations)[:, :, :2]
    return TieDerivatives(
        residuals=moved,
        first_pose=by_ground @ np.concatenate([lever, turning], 2),
        second_pose=np.concatenate([-by_point, by_point @ _cross(point - second.centres)], 2),
        first_lens=np.einsum('nij,njk->nik', by_ray, _ray_by_lens(first, first.straightened()[1])),
        second_lens=_pixel_by_lens(second, seen, second.straightened()[1]),
    )


def sighting_residuals(views: Views, points: FloatArray) -> TieResiduals:
    """Project `points` (n, 3) of the ground into `views`, where they were sighted."""
    return _sighted(views, points)[0]


def sighting_derivatives(views: Views, points: FloatArray) -> TieDerivatives:
    """Project `points` (n, 3) into `views`; ``first_pose`` is by the point, (n, 2, 3)."""
    moved, seen, by_point = _sighted(views, points)
    return TieDerivatives(
        residuals=moved,
        first_pose=by_point,
        second_pose=np.concatenate([-by_point, by_point @ _cross(points - views.centres)], 2),
        first_lens=np.zeros((len(points), 2, 0)),
        second_lens=_pixel_by_lens(views, seen, views.straightened()[1]),
    )


def _sighted(views: Views, points: FloatArray) -> tuple[TieResiduals, FloatArray, FloatArray]:
    seen, by_point = _seen(views, points)
    target = views.straightened()[0] * views.focal_px[:, np.newaxis]
    moved = TieResiduals(
        residuals_px=seen - target, ground_m=points[:, :2], height=by_point[:, :, 2]
    )
    return moved, seen, by_point


def _rays(first: Views) -> _Rays:
    directions = np.einsum('nij,nj->ni', first.rotations, _with_one(first.straightened()[0]))
    drop = np.maximum(-directions[:, 2], 1e-6)
    return _Rays(directions=directions, drop=drop, slope=directions[:, :2] / drop[:, np.newaxis])


def _met(first: Views, rays: _Rays, heights_m: FloatArray) -> FloatArray:
    reach = first.centres[:, 2] - heights_m
    ground: FloatArray = first.centres[:, :2] + rays.slope * reach[:, np.newaxis]
    return ground


def _residuals(
    first: Views, second: Views, rays: _Rays, heights_m: FloatArray
) -> tuple[TieResiduals, FloatArray, FloatArray]:
    """Return the residuals, where the points are seen (n, 2), and its derivative (n, 2, 3)."""
    ground = _met(first, rays, heights_m)
    seen, by_point = _seen(second, np.column_stack([ground, heights_m]))
    target = second.straightened()[0] * second.focal_px[:, np.newaxis]
    moved = TieResiduals(
        residuals_px=seen - target,
        ground_m=ground,
        height=by_point[:, :, 2] - np.einsum('nij,nj->ni', by_point[:, :, :2], rays.slope),
    )
    return moved, seen, by_point


def _seen(views: Views, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where `points` (n, 3) are seen (n, 2), and its derivative to them (n, 2, 3)."""
    turned = np.einsum('nji,nj->ni', views.rotations, points - views.centres)
    depth = np.maximum(turned[:, 2], 1e-6)
    seen = turned[:, :2] / depth[:, np.newaxis]
    scale = (views.focal_px / depth)[:, np.newaxis, np.newaxis]
    by_turned = np.concatenate(
        [np.broadcast_to(np.eye(2), (len(seen), 2, 2)), -seen[:, :, np.newaxis]], 2
    )
    by_point = scale * (by_turned @ np.swapaxes(views.rotations, 1, 2))
    return seen * views.focal_px[:, np.newaxis], by_point


def _ray_by_lens(views: Views, bent: FloatArray) -> FloatArray:
    """Return the derivative of straightened rays to log f, k1, k2; (n, 2, 3)."""
    square = np.sum(bent**2, axis=1)
    k1, k2 = views.radial.T
    by_log_focal = -bent * (1.0 + 3.0 * k1 * square + 5.0 * k2 * square**2)[:, np.newaxis]
    parts = [by_log_focal, bent * square[:, np.newaxis], bent * (square**2)[:, np.newaxis]]
    return np.stack(parts, axis=2)


def _pixel_by_lens(views: Views, seen: FloatArray, bent: FloatArray) -> FloatArray:
    """Return the derivative of (seen - target) to the lens's log f, k1, k2; (n, 2, 3)."""
    target = _ray_by_lens(views, bent) * views.focal_px[:, np.newaxis, np.newaxis]
    straight, _ = views.straightened()
    target[:, :, 0] += straight * views.focal_px[:, np.newaxis]
    by_lens = -target
    by_lens[:, :, 0] += seen
    return by_lens


def _cross(vectors: FloatArray) -> FloatArray:
    """Return the matrices (n, 3, 3) of the cross products with `vectors` (n, 3)."""
    matrix = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    matrix[:, 0, 1], matrix[:, 0, 2], matrix[:, 1, 2] = -z, y, -x
    matrix[:, 1, 0], matrix[:, 2, 0], matrix[:, 2, 1] = z, -y, x
    return matrix


def _with_one(rays: FloatArray) -> FloatArray:
    return np.column_stack([rays, np.ones(len(rays))])
