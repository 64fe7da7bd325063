# SPDX-License-Identifier: Apache-2.0
"""Tiles: the dirt and wear that lies on all things, and the leaves on the skin of crowns."""

import math

import numpy as np
from numpy.typing import NDArray

from rocsafe_sim.scene.mesh import Floats

TILE_PX = 1024
# Of the leaves: texels, and their width, metres.
LEAVES_PX, LEAF_TEXEL_M = 2048, 0.03
# Scales of leaves, twigs and boughs, metres, and how much each varies.
_LEAF_BANDS = ((0.075, 1.5), (0.2, 0.8), (0.5, 1.0), (1.2, 0.7))


def grain_tile(seed: int = 5) -> NDArray[np.uint8]:
    """Return noise without seams, (1024, 1024, 4): of centimetres, of hands, in streaks, in spots.

    Each is shaped from white noise by its spectrum, and spread evenly over 0 to 255.
    """
    rng = np.random.default_rng(seed)
    across, along = (f(TILE_PX, 1.0 / TILE_PX) for f in (np.fft.rfftfreq, np.fft.fftfreq))
    fx, fy = np.meshgrid(across, along)
    radius = np.hypot(fx, fy) + 1e-9
    fine = _shaped(rng, radius**-0.55 * (radius > 12.0))
    blotches = _shaped(rng, np.exp(-((radius / 60.0) ** 2)) * radius**-1.0 * (radius > 1.5))
    stretched = np.hypot(fx, 7.0 * fy) + 1e-9
    streaks = _shaped(rng, stretched**-0.9 * (stretched > 6.0))
    coarse = _shaped(rng, radius**-1.25 * (radius > 2.5))
    layers = [_levelled(fine), _levelled(blotches), _levelled(streaks), _levelled(coarse)]
    return np.stack(layers, axis=-1)


def leaf_tile(seed: int = 8) -> NDArray[np.uint8]:
    """Return how bright the leaves of a dense crown are, (2048, 2048), without seams.

    61 m wide, and as much again mirrored: within sight nothing comes twice.
    """
    rng = np.random.default_rng(seed)
    across, along = (f(LEAVES_PX, LEAF_TEXEL_M) for f in (np.fft.rfftfreq, np.fft.fftfreq))
    fx, fy = np.meshgrid(across.astype(np.float32), along.astype(np.float32))
    octave = np.log2(np.hypot(fx, fy) + 1e-6)
    power = sum((weight * np.exp(-0.5 * ((octave + math.log2(scale_m)) / 0.42) ** 2)
                 * scale_m for scale_m, weight in _LEAF_BANDS), np.float32(0.0))  # fmt: skip
    turn = rng.uniform(0.0, 2.0 * math.pi, octave.shape).astype(np.float32)
    return _levelled(np.fft.irfft2(power * np.exp(1j * turn)))


def _shaped(rng: np.random.Generator, spectrum: Floats) -> Floats:
    noise = np.fft.rfft2(rng.standard_normal((TILE_PX, TILE_PX)))
    return np.asarray(np.fft.irfft2(noise * spectrum))


def _levelled(values: Floats) -> NDArray[np.uint8]:
    scaled = (values - values.mean()) / values.std()
    return np.clip(127.5 + 48.0 * scaled, 0.0, 255.0).astype(np.uint8)
