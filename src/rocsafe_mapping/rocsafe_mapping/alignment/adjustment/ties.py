# SPDX-License-Identifier: Apache-2.0
"""Ties of many pairs as arrays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.alignment.adjustment.projection import (
    TieDerivatives,
    TieResiduals,
    Views,
    grounded,
    tie_derivatives,
    tie_residuals,
)
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment.model.photo import Photo
from rocsafe_mapping.alignment.model.state import Lens, State

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ties:
    """All ties of a set of pairs.

    Attributes
    ----------
    names
        Photographs, sorted; `first` and `second` count in them, shape (n,).
    lenses
        Of each photograph.
    first_offsets_px, second_offsets_px
        Pixels less the principal point, shape (n, 2).
    focal_px
        Believed focal length of each photograph.
    """

    names: tuple[str, ...]
    lenses: tuple[str, ...]
    focal_px: FloatArray
    first: Index
    second: Index
    first_offsets_px: FloatArray
    second_offsets_px: FloatArray

    def __len__(self) -> int:
        return len(self.first)

    def residuals(self, state: State) -> TieResiduals:
        """Return residuals on the ground of `state`."""
        first, second = self._views(state)
        return tie_residuals(first, second, _heights(first, state))

    def derivatives(self, state: State) -> TieDerivatives:
        """Return residuals and derivatives on the ground of `state`."""
        first, second = self._views(state)
        return tie_derivatives(first, second, _heights(first, state))

    def _views(self, state: State) -> tuple[Views, Views]:
        """Return both ends of the ties."""
        poses = [state.poses[name] for name in self.names]
        lenses = [state.lenses.get(lens, Lens()) for lens in self.lenses]
        focal = self.focal_px * np.exp([lens.log_focal for lens in lenses])
        radial = np.array([(lens.k1, lens.k2) for lens in lenses])
        centres = np.array([pose.centre for pose in poses])
        rotations = np.array([pose.rotation for pose in poses])
        first, second = (
            Views(
                offsets_px=offsets,
                focal_px=focal[index],
                radial=radial[index],
                centres=centres[index],
                rotations=rotations[index],
            )
            for index, offsets in (
                (self.first, self.first_offsets_px),
                (self.second, self.second_offsets_px),
            )
        )
        return first, second


def _heights(first: Views, state: State) -> FloatArray:
    """Return the height of the ground (n,) that the first photograph's pixels show."""
    heights: FloatArray = np.zeros(len(first.centres))
    if not state.surface.is_level:
        for _ in range(2):
            heights = state.surface.at(grounded(first, heights))
    return heights


def ties_of(
    pairs: Sequence[Pair],
    photos: Mapping[str, Photo],
    *,
    held_out: bool,
    most: int,
) -> Ties:
    """Return about `most` ties of `pairs` that were held out, or of those that were not."""
    names = tuple(sorted({pair.first for pair in pairs} | {pair.second for pair in pairs}))
    index = {name: number for number, name in enumerate(names)}
    chosen = [pair.is_held_out == held_out for pair in pairs]
    # With many photographs fewer ties of each pair are enough; this limits memory.
    every = -(-sum(int(mask.sum()) for mask in chosen) // most)
    if every > 1:
        chosen = [mask & (np.cumsum(mask) % every == 1) for mask in chosen]
    counts = [int(mask.sum()) for mask in chosen]
    cameras = [photos[name].camera for name in names]
    middles = np.array([(camera.cx_px, camera.cy_px) for camera in cameras]).reshape(-1, 2)
    # Rows are scaled like columns, so that pixels are square.
    aspect = np.array([(1.0, camera.fx_px / camera.fy_px) for camera in cameras]).reshape(-1, 2)
    first = np.repeat([index[pair.first] for pair in pairs], counts).astype(np.int64)
    second = np.repeat([index[pair.second] for pair in pairs], counts).astype(np.int64)
    return Ties(
        names=names,
        lenses=tuple(photos[name].lens for name in names),
        focal_px=np.array([camera.fx_px for camera in cameras]),
        first=first,
        second=second,
        first_offsets_px=_offsets([p.first_px for p in pairs], chosen, middles, aspect, first),
        second_offsets_px=_offsets([p.second_px for p in pairs], chosen, middles, aspect, second),
    )


def _offsets(
    pixels: Sequence[FloatArray],
    chosen: Sequence[BoolArray],
    middles: FloatArray,
    aspect: FloatArray,
    index: Index,
) -> FloatArray:
    parts = [points[mask] for points, mask in zip(pixels, chosen, strict=True)]
    together = np.concatenate(parts) if parts else np.zeros((0, 2))
    return (together - middles[index]) * aspect[index]
