# SPDX-License-Identifier: Apache-2.0
"""Whether two photographs show the same ground, and which of their pixels are the same point."""

import itertools
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.alignment.matching.features import Features, Gray
from rocsafe_mapping.alignment.matching.parallax import off_plane, transformed
from rocsafe_mapping.alignment.matching.refinement import refined
from rocsafe_mapping.alignment.model.photo import Photo, camera_matrix
from rocsafe_mapping.alignment_options import AlignmentOptions, MatchingOptions

Name = TypeVar('Name', str, int)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Pair:
    """Two photographs of the same ground.

    Attributes
    ----------
    first, second
        Their names.
    first_px, second_px
        The same points in each, shape (n, 2).
    is_held_out
        Shape (n,): ties that only judge the adjustment and never enter it.
    method
        Descriptor by which they were found: orb or sift.
    """

    first: str
    second: str
    first_px: FloatArray
    second_px: FloatArray
    is_held_out: BoolArray
    method: str

    def __len__(self) -> int:
        return len(self.first_px)


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """A photograph, its features, and its grey picture when they are to be refined."""

    photo: Photo
    features: Features
    gray: Callable[[], Gray]


def match(first: View, second: View, method: str, options: AlignmentOptions) -> Pair | None:
    """Return the ties of two photographs, None if they do not certainly show the same ground."""
    matching = options.matching
    near_first, near_second = _nearby(first, second), _nearby(second, first)
    zoom = _zoom(first.photo, second.photo)
    # A few show whether the photographs fit, and where to search for the others.
    coarse = _coarse(near_first, near_second, matching.few, zoom, matching)
    if coarse is None:
        # The fixes or the yaw are wrong: all features are compared.
        coarse = _coarse(first.features, second.features, matching.many, zoom, matching)
    found = None if coarse is None else _verified(first, second, coarse, zoom, options)
    if found is None:
        return None
    first_px, second_px = refined(first.gray(), second.gray(), *found, options.refinement)
    every = matching.held_out_every
    held_out = np.arange(len(first_px)) % every == every - 1
    return Pair(
        first=first.photo.name,
        second=second.photo.name,
        first_px=first_px,
        second_px=second_px,
        is_held_out=held_out,
        method=method,
    )


def _coarse(
    features: Features, others: Features, count: int, zoom: float, options: MatchingOptions
) -> FloatArray | None:
    """Return the homography that the first `count` features suggest."""
    matches = mutual_matches(features.first(count), others.first(count), options)
    found = _homography(
        features, others, matches, options.coarse_inliers, options.coarse_share, options
    )
    if found is None or not _is_plausible(found[0], found[1], zoom, options):
        return None
    return found[0]


def _nearby(view: View, other: View) -> Features:
    """Return the features of `view` that `other` may see by the priors, with a margin."""
    photo, partner = view.photo, other.photo
    if not (photo.has_yaw and partner.has_yaw and photo.has_height and partner.has_height):
        return view.features
    back = np.asarray(np.linalg.inv(_ground_to_pixel(photo)), float)
    matrix = _ground_to_pixel(partner) @ back
    std_m = np.hypot(photo.horizontal_std_m, partner.horizontal_std_m)
    std_rad = np.hypot(photo.tilt_std_rad, partner.tilt_std_rad)
    margin_px = 2.5 * std_m / partner.ground_resolution_m + 2.0 * std_rad * partner.camera.fx_px
    return _seen_by(view.features, matrix, partner, float(margin_px))


def _seen_by(features: Features, matrix: FloatArray, other: Photo, margin_px: float) -> Features:
    """Return the features that the homography `matrix` puts into or near the image of `other`."""
    points = features.points_px.astype(float)
    seen = transformed(matrix, points)
    size = np.array([other.camera.width_px, other.camera.height_px])
    return features.subset(np.all((seen > -margin_px) & (seen < size + margin_px), axis=1))


def _ground_to_pixel(photo: Photo) -> FloatArray:
    centre = photo.prior.centre
    ground = np.eye(3)
    ground[:, 2] = -centre
    matrix: FloatArray = camera_matrix(photo.camera) @ photo.prior.rotation.T @ ground
    return matrix


def _verified(
    first: View, second: View, coarse: FloatArray, zoom: float, options: AlignmentOptions
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return homography and ties of all features near a first homography; None if not certain."""
    matching = options.matching
    features = _seen_by(first.features, coarse, second.photo, matching.guided_margin_px)
    back = np.asarray(np.linalg.inv(coarse), float)
    others = _seen_by(second.features, back, first.photo, matching.guided_margin_px)
    matches = mutual_matches(features, others, matching)
    found = _homography(
        features, others, matches, matching.least_inliers, matching.least_inlier_share, matching
    )
    if found is None:
        return None
    homography, first_px, second_px = found
    is_good = _is_spread(first_px, first.photo, matching) and _is_plausible(
        homography, first_px, zoom, matching
    )
    if is_good and len(first_px) < matching.strong_inliers:
        is_good = _fits_fixes(homography, first.photo, second.photo, matching)
    if not is_good:
        return None
    chosen = _spread(first_px, first.photo, matching.most_ties, matching.tie_cells)
    all_first, all_second = _points(features, others, matches)
    camera = second.photo.camera
    middle = np.array([camera.cx_px, camera.cy_px])
    is_tall = off_plane(homography, all_first, all_second, middle, options.parallax)
    tall = np.flatnonzero(is_tall)[
        _spread(all_first[is_tall], first.photo, matching.most_tall_ties, matching.tie_cells)
    ]
    return (
        homography,
        np.concatenate([first_px[chosen], all_first[tall]]),
        np.concatenate([second_px[chosen], all_second[tall]]),
    )


def _homography(
    features: Features,
    others: Features,
    matches: NDArray[np.int64],
    least: int,
    share: float,
    options: MatchingOptions,
) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return a homography with its inliers, None with fewer than `least` or that share."""
    if len(matches) < least:
        return None
    first_px, second_px = _points(features, others, matches)
    homography, mask = cv2.findHomography(
        first_px, second_px, cv2.USAC_MAGSAC, options.inlier_px, maxIters=2000, confidence=0.999
    )
    if homography is None:
        return None
    inside = mask.ravel().astype(bool)
    if inside.sum() < least or inside.mean() < share:
        return None
    return homography, first_px[inside], second_px[inside]


def _points(
    features: Features, others: Features, matches: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray]:
    """Return the pixels of matches, (n, 2) each."""
    return (
        features.points_px[matches[:, 0]].astype(float),
        others.points_px[matches[:, 1]].astype(float),
    )


def mutual_matches(
    features: Features, others: Features, options: MatchingOptions
) -> NDArray[np.int64]:
    """Return index pairs (n, 2) that pass the ratio test, each feature at most once."""
    if len(features) < 2 or len(others) < 2:
        return np.zeros((0, 2), np.int64)
    matcher = cv2.BFMatcher(features.norm)
    best: dict[int, tuple[float, int]] = {}
    for found in matcher.knnMatch(features.descriptors, others.descriptors, 2):
        nearest, other = found
        if nearest.distance >= options.ratio * other.distance:
            continue
        rival = best.get(nearest.trainIdx)
        if rival is None or nearest.distance < rival[0]:
            best[nearest.trainIdx] = (nearest.distance, nearest.queryIdx)
    kept = sorted((index, there) for there, (_, index) in best.items())
    return np.array(kept, np.int64).reshape(-1, 2)


def most_alike(
    features: Mapping[Name, Features],
    wanted: Collection[Name],
    most: int,
    options: MatchingOptions,
) -> set[tuple[Name, Name]]:
    """Return the pairs of each of the `wanted` photographs with the `most` most like it.

    They are those with which it has most mutual matches of few `features`.
    """
    counts: dict[Name, list[tuple[int, Name]]] = {name: [] for name in wanted}
    for one, other in itertools.combinations(sorted(features), 2):
        if one in counts or other in counts:
            count = len(mutual_matches(features[one], features[other], options))
            for name, partner in ((one, other), (other, one)):
                if name in counts:
                    counts[name].append((-count, partner))
    return {
        (min(name, other), max(name, other))
        for name, found in counts.items()
        for _, other in sorted(found)[:most]
    }


def _is_spread(points: FloatArray, photo: Photo, options: MatchingOptions) -> bool:
    cell = options.cell_share * photo.camera.height_px
    return len(np.unique((points // cell).astype(int), axis=0)) >= options.least_cells


def _zoom(first: Photo, second: Photo) -> float:
    """Return how much larger the second shows the ground, by focal lengths and heights."""
    zoom = second.camera.fx_px / first.camera.fx_px
    if first.has_height and second.has_height:
        zoom *= float(first.prior.centre[2] / second.prior.centre[2])
    return zoom


def _is_plausible(
    homography: FloatArray, points: FloatArray, zoom: float, options: MatchingOptions
) -> bool:
    """Return whether the homography is one between two cameras that look down on level ground."""
    areas = []
    for place in (points.mean(axis=0), points.min(axis=0), points.max(axis=0)):
        jacobian = _jacobian(homography, place)
        large, small = np.linalg.svd(jacobian, compute_uv=False)
        areas.append(float(np.linalg.det(jacobian)))
        if small <= 0.0 or areas[-1] <= 0.0 or large / small > options.largest_stretch:
            return False
    scale = areas[0] ** 0.5 / zoom
    bend = max(areas) / min(areas)
    is_scaled = options.smallest_scale < scale < options.largest_scale
    return is_scaled and bend < options.largest_bend


def _jacobian(homography: FloatArray, place: FloatArray) -> FloatArray:
    x, y, w = homography @ np.array([*place, 1.0])
    jacobian: FloatArray = (homography[:2, :2] * w - np.outer([x, y], homography[2, :2])) / w**2
    return jacobian


def _fits_fixes(
    homography: FloatArray, first: Photo, second: Photo, options: MatchingOptions
) -> bool:
    """Return whether the cameras are as far apart as their fixes say, whatever their yaw.

    False where a height is unknown: the pair is tried again when it is known.
    """
    if not (first.has_height and second.has_height):
        return False
    middle = np.array([first.camera.cx_px, first.camera.cy_px, 1.0])
    x, y, w = homography @ middle
    shift_px = np.hypot(x / w - second.camera.cx_px, y / w - second.camera.cy_px)
    seen_m = shift_px * second.ground_resolution_m
    flown_m = float(np.linalg.norm(first.prior.centre[:2] - second.prior.centre[:2]))
    std_m = np.hypot(first.horizontal_std_m, second.horizontal_std_m)
    tilt_m = np.hypot(first.tilt_std_rad, second.tilt_std_rad) * first.prior.centre[2]
    slack_m = options.baseline_stds * np.hypot(std_m, tilt_m) + options.baseline_share * flown_m
    return bool(abs(seen_m - flown_m) < slack_m)


def _spread(points: FloatArray, photo: Photo, most: int, tie_cells: int) -> NDArray[Any]:
    """Return which of the points to keep, at most `most`, taken in turn from a grid."""
    if len(points) <= most:
        return np.arange(len(points))
    size = np.array([photo.camera.width_px, photo.camera.height_px]) / tie_cells
    cells = (points // size).astype(int) @ np.array([1, tie_cells])
    order = np.argsort(cells, kind='stable')
    rank = np.arange(len(order)) - np.searchsorted(cells[order], cells[order])
    return np.sort(order[np.argsort(rank, kind='stable')[:most]])
