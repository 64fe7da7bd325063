# SPDX-License-Identifier: Apache-2.0
"""Sightings of surveyed marks as arrays, and where the photographs put the marks."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.projection import (
    TieDerivatives,
    TieResiduals,
    Views,
    grounded,
    sighting_derivatives,
    sighting_residuals,
)
from rocsafe_mapping.alignment.model.mark import Mark
from rocsafe_mapping.alignment.model.photo import Photo
from rocsafe_mapping.alignment.model.state import Lens, Noise, State

POINTING_STD_PX = 1.0
"""How well a person points at a mark in a photograph."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sightings:
    """All sightings of marks in photographs that have a pose.

    Attributes
    ----------
    names, lenses
        Photograph and lens of each sighting.
    marks
        Index of the mark of each among those of the state, shape (n,).
    offsets_px
        Pixels less the principal point, shape (n, 2).
    focal_px
        Believed focal length, shape (n,).
    """

    names: tuple[str, ...]
    lenses: tuple[str, ...]
    marks: FloatArray
    offsets_px: FloatArray
    focal_px: FloatArray

    def __len__(self) -> int:
        return len(self.names)

    def residuals(self, state: State) -> TieResiduals:
        """Return where the marks are seen, less where they were sighted."""
        return sighting_residuals(self._views(state), self._points(state))

    def derivatives(self, state: State) -> TieDerivatives:
        """Return residuals and derivatives; `first_pose` has those to the mark's place."""
        return sighting_derivatives(self._views(state), self._points(state))

    def grounded_m(self, state: State) -> FloatArray:
        """Return where each sighting meets the ground, shape (n, 2)."""
        views = self._views(state)
        heights: FloatArray = np.zeros(len(self))
        for _ in range(3):
            heights = state.surface.at(grounded(views, heights))
        return grounded(views, heights)

    def _points(self, state: State) -> FloatArray:
        places = np.array([state.marks[at].found_m for at in self.marks])
        return np.column_stack([places, state.surface.at(places)])

    def _views(self, state: State) -> Views:
        poses = [state.poses[name] for name in self.names]
        lenses = [state.lenses.get(lens, Lens()) for lens in self.lenses]
        return Views(
            offsets_px=self.offsets_px,
            focal_px=self.focal_px * np.exp([lens.log_focal for lens in lenses]),
            radial=np.array([(lens.k1, lens.k2) for lens in lenses]),
            centres=np.array([pose.centre for pose in poses]),
            rotations=np.array([pose.rotation for pose in poses]),
        )


def sightings_of(marks: Sequence[Mark], photos: Mapping[str, Photo], state: State) -> Sightings:
    """Return the sightings of `marks` in the photographs that have a pose."""
    rows = [
        (name, number, pixel)
        for number, mark in enumerate(marks)
        for name, pixel in sorted(mark.sightings.items())
        if name in state.poses
    ]
    cameras = [photos[name].camera for name, _, _ in rows]
    offsets = [
        (pixel - (camera.cx_px, camera.cy_px)) * (1.0, camera.fx_px / camera.fy_px)
        for (_, _, pixel), camera in zip(rows, cameras, strict=True)
    ]
    return Sightings(
        names=tuple(name for name, _, _ in rows),
        lenses=tuple(photos[name].lens for name, _, _ in rows),
        marks=np.array([number for _, number, _ in rows], np.int64),
        offsets_px=np.array(offsets).reshape(-1, 2),
        focal_px=np.array([camera.fx_px for camera in cameras]),
    )


def pointing_noise(noise: Noise) -> Noise:
    """Return the noise of sightings: that of ties, and of pointing at a mark."""
    return dataclasses.replace(noise, tie_std_px=math.hypot(noise.tie_std_px, POINTING_STD_PX))


def mark_places_m(
    marks: Sequence[Mark], photos: Mapping[str, Photo], state: State
) -> dict[str, FloatArray]:
    """Return where the photographs put marks, (east, north) by name; the mean of all sightings."""
    sightings = sightings_of(marks, photos, state)
    if not len(sightings):
        return {}
    places = sightings.grounded_m(state)
    return {
        marks[number].name: places[sightings.marks == number].mean(axis=0)
        for number in sorted(set(sightings.marks.tolist()))
    }
