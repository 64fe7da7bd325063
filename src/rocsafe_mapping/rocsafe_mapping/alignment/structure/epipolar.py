# SPDX-License-Identifier: Apache-2.0
"""Matches of two photographs that look in any direction, and points that several show."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.matching.features import Features
from rocsafe_mapping.alignment.matching.pair_matching import mutual_matches
from rocsafe_mapping.alignment_options import MatchingOptions, StructureOptions

Index = NDArray[np.int64]
Key = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """Two photographs that show the same points.

    Attributes
    ----------
    matches
        Features of the first and the second, shape (n, 2).
    rotation, direction
        From the optical frame of the first to that of the second, and where the first one's
        centre lies there, of length 1.
    angle_rad
        Median angle between the two rays to a point.
    """

    matches: Index
    rotation: FloatArray
    direction: FloatArray
    angle_rad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Tracks:
    """Points that several photographs show.

    Attributes
    ----------
    photos, features, points
        Photograph, feature and point of each sighting, shape (n,), sorted by photograph.
    count
        Number of points.
    """

    photos: Index
    features: Index
    points: Index
    count: int


def linked(
    first: Features,
    second: Features,
    rays: tuple[FloatArray, FloatArray],
    focal_px: float,
    matching: MatchingOptions,
    options: StructureOptions,
) -> Link | None:
    """Return what ties two photographs by the epipolar geometry; None if it is not certain.

    Parameters
    ----------
    first, second
        Their features.
    rays
        Directions x / z, y / z of these features in each camera, (n, 2).
    focal_px
        Focal length.
    """
    matches = mutual_matches(first, second, matching)
    if len(matches) < options.least_matches:
        return None
    one, other = rays[0][matches[:, 0]], rays[1][matches[:, 1]]
    cv2.setRNGSeed(0)
    essential, mask = cv2.findEssentialMat(
        one, other, np.eye(3), cv2.USAC_MAGSAC, 0.999, options.epipolar_px / focal_px, 5000
    )
    if essential is None or essential.shape != (3, 3):
        return None
    inside = mask.ravel().astype(bool)
    if inside.sum() < options.least_matches or inside.mean() < options.least_share:
        return None
    matches, one, other = matches[inside], one[inside], other[inside]
    count, rotation, direction, _ = cv2.recoverPose(essential, one, other, np.eye(3))
    if count < options.least_front_share * len(matches):
        return None
    turned = np.column_stack([one, np.ones(len(one))]) @ rotation.T
    straight = np.column_stack([other, np.ones(len(other))])
    cosines = np.sum(turned * straight, axis=1)
    cosines /= np.linalg.norm(turned, axis=1) * np.linalg.norm(straight, axis=1)
    return Link(
        matches=matches,
        rotation=rotation,
        direction=direction.ravel(),
        angle_rad=float(np.median(np.arccos(np.clip(cosines, -1.0, 1.0)))),
    )


def tracks_of(links: Mapping[Key, Link], counts: Sequence[int]) -> Tracks:
    """Return the points that `links` join; `counts` are the features of each photograph.

    A point that one photograph shows twice is left out.
    """
    starts = np.concatenate([[0], np.cumsum(counts)])
    parent = np.arange(starts[-1])

    def root(node: int) -> int:
        while parent[node] != node:
            parent[node] = parent[parent[node]]
            node = parent[node]
        return node

    for (first, second), link in sorted(links.items()):
        for one, other in link.matches.tolist():
            ends = root(starts[first] + one), root(starts[second] + other)
            parent[max(ends)] = min(ends)
    roots = np.array([root(node) for node in range(starts[-1])], np.int64)
    _, group, sizes = np.unique(roots, return_inverse=True, return_counts=True)
    nodes = np.flatnonzero(sizes[group] > 1)
    photos = np.searchsorted(starts, nodes, side='right') - 1
    pairs, seen = np.unique(np.column_stack([group[nodes], photos]), axis=0, return_counts=True)
    twice = np.isin(group[nodes], pairs[seen > 1, 0])
    nodes, photos = nodes[~twice], photos[~twice]
    _, points = np.unique(group[nodes], return_inverse=True)
    count = int(points.max()) + 1 if len(points) else 0
    return Tracks(photos=photos, features=nodes - starts[photos], points=points, count=count)
