# SPDX-License-Identifier: Apache-2.0
"""Points of a photograph that can be found again in others."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.alignment_options import FeatureOptions

Gray = NDArray[np.uint8]


@dataclass(frozen=True, slots=True, kw_only=True)
class Features:
    """Points with descriptors.

    Attributes
    ----------
    points_px
        Shape (n, 2); the strongest, spread over the image, come first.
    descriptors
        Shape (n, 32) of bytes for ORB, (n, 128) of floats for SIFT.
    """

    points_px: NDArray[np.float32]
    descriptors: NDArray[Any]

    def __len__(self) -> int:
        return len(self.points_px)

    def subset(self, chosen: NDArray[Any]) -> 'Features':
        """Return some of them."""
        return Features(points_px=self.points_px[chosen], descriptors=self.descriptors[chosen])

    def first(self, count: int) -> 'Features':
        """Return the first `count`: the strongest of ORB, the coarsest of SIFT."""
        return Features(points_px=self.points_px[:count], descriptors=self.descriptors[:count])

    @property
    def norm(self) -> int:
        """Distance between descriptors that OpenCV shall use."""
        is_binary = self.descriptors.dtype == np.uint8
        return int(cv2.NORM_HAMMING if is_binary else cv2.NORM_L2)


def orb_features(gray: Gray, options: FeatureOptions) -> Features:
    """Return about `options.count` ORB features (Rublee et al. 2011), spread over the image."""
    detector, describer = (
        _orb(options.surplus * options.count, options),
        _orb(options.count, options),
    )
    small, scale = _searched(gray, options)
    found = detector.detect(small, None)
    kept = _spread(found, small.shape, options)
    points, descriptors = describer.compute(small, kept)
    return _features(points, descriptors, scale, np.zeros((0, 32), np.uint8))


def sift_features(gray: Gray, options: FeatureOptions) -> Features:
    """Return about `options.count` SIFT features (Lowe 2004), slower than ORB.

    Descriptors are compared by the Hellinger distance (Arandjelovic, Zisserman 2012): they are
    roots of the gradients' shares. The coarsest come first: few of them tell whether photographs
    show the same (Wu, Towards linear-time incremental structure from motion, 2013).
    """
    small, scale = _searched(gray, options)
    points, descriptors = _sift(options).detectAndCompute(small, None)
    if descriptors is not None:
        order = np.argsort([-point.size for point in points], kind='stable')
        points = [points[index] for index in order]
        descriptors = descriptors[order]
        descriptors = np.sqrt(descriptors / descriptors.sum(axis=1, keepdims=True).clip(1e-6))
    return _features(points, descriptors, scale, np.zeros((0, 128), np.float32))


def evened(gray: Gray, options: FeatureOptions) -> Gray:
    """Return `gray` with its local contrast raised where there is little of it."""
    if float(gray.std()) > options.low_contrast:
        return gray
    clahe = cv2.createCLAHE(options.contrast_limit, options.contrast_tiles)
    raised: Gray = clahe.apply(gray)
    return raised


def _searched(gray: Gray, options: FeatureOptions) -> tuple[Gray, float]:
    """Return the picture to search, and the size of its pixels in those of `gray`."""
    scale = max(1.0, max(gray.shape) / options.search_side_px)
    if scale == 1.0:
        return evened(gray, options), 1.0
    size = (round(gray.shape[1] / scale), round(gray.shape[0] / scale))
    return evened(cv2.resize(gray, size, interpolation=cv2.INTER_AREA), options), scale


def _spread(found: Any, shape: tuple[int, ...], options: FeatureOptions) -> list[Any]:
    """Return the strongest of `found` in each cell of a grid, about `options.count` in all."""
    if not len(found):
        return []
    places = np.array([point.pt for point in found])
    strengths = np.array([point.response for point in found])
    height, width = shape[:2]
    columns = (places[:, 0] * options.grid_cells / width).astype(int)
    rows = (places[:, 1] * options.grid_cells / height).astype(int)
    cells = rows * options.grid_cells + columns
    order = np.lexsort((-strengths, cells))
    sorted_cells = cells[order]
    starts = np.searchsorted(sorted_cells, sorted_cells)
    rank = np.arange(len(order)) - starts
    # The best of every cell, then the second best of every cell, and so on.
    chosen = order[np.lexsort((-strengths[order], rank))[: options.count]]
    return [found[index] for index in chosen]


def _features(points: Any, descriptors: Any, scale: float, empty: NDArray[Any]) -> Features:
    if descriptors is None or not len(points):
        return Features(points_px=np.zeros((0, 2), np.float32), descriptors=empty)
    # Integer coordinates are pixel centres: the corner of both pictures is at -0.5.
    found: NDArray[np.float32] = np.array([point.pt for point in points], np.float32)
    places = (found + np.float32(0.5)) * np.float32(scale) - np.float32(0.5)
    return Features(points_px=places, descriptors=descriptors)


@lru_cache(maxsize=4)
def _orb(count: int, options: FeatureOptions) -> Any:
    return cv2.ORB_create(  # type: ignore[attr-defined]
        count,
        fastThreshold=options.orb_fast_threshold,
        scaleFactor=options.orb_scale_factor,
        nlevels=options.orb_levels,
    )


@lru_cache(maxsize=2)
def _sift(options: FeatureOptions) -> Any:
    return cv2.SIFT_create(options.count, contrastThreshold=options.sift_contrast)  # type: ignore[attr-defined]
