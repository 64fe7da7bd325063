# SPDX-License-Identifier: Apache-2.0
"""Noise that depends on seed and place only: equal in every process, and without repetition.

There is a lattice of spacing 2^k cm for each octave k. The value of a lattice point is a hash of
(seed, octave, column, row). A field is computed from coarse to fine: the sum of the coarser
octaves is doubled in resolution, and the values of the octave are added. Every step is local and
aligned with the lattice, so that separately computed tiles fit without a seam.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Field = NDArray[np.float32]

CM_PER_M = 100.0
# Cubic interpolation reads two neighbours to each side.
_MARGIN = 2
# Smooth fields are computed this many octaves coarser and enlarged in one step.
_LARGEST_ZOOM_LOG2 = 3


@dataclass(frozen=True, slots=True)
class Window:
    """Columns [x0, x1) and rows [y0, y1) of a lattice; columns east, rows north."""

    x0: int
    y0: int
    x1: int
    y1: int

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.y1 - self.y0, self.x1 - self.x0

    def grown(self, margin: int) -> 'Window':
        """Return the window with `margin` more cells on each side."""
        return Window(self.x0 - margin, self.y0 - margin, self.x1 + margin, self.y1 + margin)

    def shrunk(self, factor: int) -> 'Window':
        """Return the window of `factor` times the spacing that covers this one and a margin."""
        covering = Window(
            self.x0 // factor, self.y0 // factor, -(-self.x1 // factor), -(-self.y1 // factor)
        )
        return covering.grown(_MARGIN)


def lattice(seed: int, octave: int, window: Window) -> Field:
    """Return hashed values, uniform in [-1, 1), of the lattice points in `window`; (rows, cols).

    The mixing function is lowbias32 (Wellons 2018, "Prospecting for hash functions").
    """
    key = np.uint32((seed * 0x9E3779B1 + octave * 0x85EBCA77) & 0xFFFFFFFF)
    rows = np.arange(window.y0, window.y1, dtype=np.int64).astype(np.uint32)
    columns = np.arange(window.x0, window.x1, dtype=np.int64).astype(np.uint32)
    mixed = _mix(rows * np.uint32(0xC2B2AE3D) ^ key)[:, None] + columns * np.uint32(0x27D4EB2F)
    return _mix(mixed).astype(np.float32) * np.float32(2.0**-31) - np.float32(1.0)


def fractal(seed: int, amplitudes: Mapping[int, float], octave: int, window: Window) -> Field:
    """Return the sum of octaves, sampled at the lattice points of `octave` in `window`.

    Parameters
    ----------
    seed
        Seed of the noise.
    amplitudes
        Amplitude of each octave k, spacing 2^k cm. Octaves finer than `octave` are left out: they
        average to zero.
    octave
        Octave of the lattice to sample at.
    window
        Window of that lattice.
    """
    coarsest = max(amplitudes)
    if octave > coarsest:
        return np.zeros(window.shape, np.float32)
    amplitude = np.float32(amplitudes.get(octave, 0.0))
    own = lattice(seed, octave, window) * amplitude if amplitude else None
    if octave == coarsest:
        return own if own is not None else np.zeros(window.shape, np.float32)
    parent = window.shrunk(2)
    smooth = zoomed(fractal(seed, amplitudes, octave + 1, parent), parent, 2, window)
    return smooth if own is None else cv2.add(smooth, own)


def fractal_at(seed: int, amplitudes: Mapping[int, float], octave: int, window: Window) -> Field:
    """Return `fractal`, faster where its finest octave is coarser than `octave`."""
    start = min(min(amplitudes), octave + _LARGEST_ZOOM_LOG2)
    if octave >= start:
        return fractal(seed, amplitudes, octave, window)
    factor = 2 ** (start - octave)
    parent = window.shrunk(factor)
    return zoomed(fractal(seed, amplitudes, start, parent), parent, factor, window)


def zoomed(coarse: Field, parent: Window, factor: int, window: Window) -> Field:
    """Return a lattice in `window`, interpolated from one of `factor` times its spacing."""
    rows, columns = coarse.shape
    fine = cv2.resize(coarse, (factor * columns, factor * rows), interpolation=cv2.INTER_CUBIC)
    x, y = window.x0 - factor * parent.x0, window.y0 - factor * parent.y0
    height, width = window.shape
    return np.ascontiguousarray(fine[y : y + height, x : x + width])


def _mix(value: NDArray[np.uint32]) -> NDArray[np.uint32]:
    value = value ^ (value >> np.uint32(16))
    value = value * np.uint32(0x7FEB352D)
    value ^= value >> np.uint32(15)
    value *= np.uint32(0x846CA68B)
    value ^= value >> np.uint32(16)
    return value
