# SPDX-License-Identifier: Apache-2.0
"""Annotations of the instances in an image."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rocsafe_dataset.labels.outlines import outline
from rocsafe_dataset.labels.rle import run_lengths, short_text
from rocsafe_scene.graphics.rendering import Rendering
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.scene.environment import FIRST_OBJECT_NUMBER, SceneObject


@dataclass(frozen=True, slots=True, kw_only=True)
class Annotation:
    """One instance in one image.

    Attributes
    ----------
    number
        Number of the instance in the scene.
    name
        Name of the instance.
    category
        Class number.
    box
        Column, row, width and height, pixels from the corner of the image.
    area
        Number of pixels.
    runs
        Run lengths of the mask as COCO's compressed text.
    polygon
        Outline: columns and rows as shares of width and height of the image.
    visibility
        Share that no other object hides, 0 to 1.
    is_cut
        Whether it reaches the border of the image.
    """

    number: int
    name: str
    category: int
    box: tuple[int, int, int, int]
    area: int
    runs: str
    polygon: tuple[float, ...]
    visibility: float
    is_cut: bool


def large_enough(frame: Rendering, least_pixels: int) -> list[int]:
    """Return the numbers of the instances with at least `least_pixels`, rising."""
    counts = np.bincount(frame.numbers.ravel())
    found = np.flatnonzero(counts >= least_pixels).tolist()
    return [number for number in found if number >= FIRST_OBJECT_NUMBER]


def annotate(
    frame: Rendering, objects: Mapping[int, SceneObject], shares: Mapping[int, float]
) -> list[Annotation]:
    """Return the annotations of the instances in `shares`, their visibility by number."""
    return [_annotation(frame, objects[number], shares[number]) for number in sorted(shares)]


def _annotation(frame: Rendering, thing: SceneObject, share: float) -> Annotation:
    mask = frame.numbers == thing.number
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    top, bottom, left, right = int(rows[0]), int(rows[-1]), int(columns[0]), int(columns[-1])
    height, width = mask.shape
    ring = np.array([left, top]) + outline(mask[top : bottom + 1, left : right + 1])
    relative = np.clip(ring / (width, height), 0.0, 1.0)
    return Annotation(
        number=thing.number,
        name=thing.name,
        category=class_number(thing.label),
        box=(left, top, right - left + 1, bottom - top + 1),
        area=int(mask.sum()),
        runs=short_text(run_lengths(mask)),
        polygon=tuple(round(value, 6) for value in relative.ravel().tolist()),
        visibility=round(share, 4),
        is_cut=left == 0 or top == 0 or right == width - 1 or bottom == height - 1,
    )
