# SPDX-License-Identifier: Apache-2.0
"""Textures: dirt and wear of all surfaces, and leaves on the surface of crowns."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_scene.mesh.mesh import Floats

# Width of each texture in texels.
TILE_PX = 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class LeafTextureOptions:
    """Sizes in the texture of leaves, which give points that match between photographs.

    Attributes
    ----------
    texel_m
        Width of a texel, metres.
    spray_m, clump_m, gap_m, bough_m
        Widths of leaf sprays, of clumps, of the gaps between them and of boughs, metres.
    """

    texel_m: float = 0.03
    spray_m: float = 0.13
    clump_m: float = 0.32
    gap_m: float = 0.45
    bough_m: float = 1.1

    @property
    def width_m(self) -> float:
        """Width of the texture, metres."""
        return TILE_PX * self.texel_m


LEAVES = LeafTextureOptions()


@lru_cache(maxsize=1)
def grain_tile() -> NDArray[np.uint8]:
    """Return noise that tiles without seams, (1024, 1024, 4): fine, coarse, streaks, spots.

    Each channel is white noise filtered to a spectrum, with values evenly over 0 to 255.
    """
    rng = np.random.default_rng(5)
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


@lru_cache(maxsize=1)
def leaf_tile() -> NDArray[np.uint8]:
    """Return how bright the leaves of a dense crown are, (1024, 1024).

    Sprays and clumps of leaves have a tone of their own and a dark rim, with dark gaps between
    them. The texture is 31 m wide and is mirrored beyond. The gaps help to match photographs: with
    plain noise of the same contrast half as many points match.
    """
    rng = np.random.default_rng(8)
    spray, spray_tone, _ = _cells(rng, LEAVES.spray_m)
    clump, clump_tone, _ = _cells(rng, LEAVES.clump_m)
    gap, _, chance = _cells(rng, LEAVES.gap_m)
    _, bough_tone, _ = _cells(rng, LEAVES.bough_m)
    sprays = 0.6 * spray_tone - 1.2 * (spray - 0.5)
    clumps = 0.7 * clump_tone - 2.0 * (clump - 0.5)
    boughs = 0.5 * cv2.GaussianBlur(bough_tone, (0, 0), 8.0)
    # Most gaps are small; their rims follow the leaves.
    width = 0.06 + 0.26 * chance**2
    edge = LEAVES.gap_m * gap + 0.06 * sprays + 0.08 * clumps
    gaps = np.clip(2.0 * (width - edge) / width, 0.0, 1.0)
    light = 1.2 * (0.45 * sprays + 0.5 * clumps + boughs) - 1.9 * gaps
    return _levelled(cv2.GaussianBlur(light, (0, 0), 0.8))


def _cells(rng: np.random.Generator, width_m: float) -> tuple[Floats, Floats, Floats]:
    """Return Voronoi cells around random places, `width_m` wide on average.

    The three images are the distance from the cell's place in widths, and a normal and a uniform
    random number of each cell.
    """
    places = rng.integers(0, TILE_PX, (2, round((LEAVES.width_m / width_m) ** 2)))
    is_off = np.ones((TILE_PX, TILE_PX), np.uint8)
    is_off[tuple(places)] = 0
    distance, cell = cv2.distanceTransformWithLabels(
        is_off, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    count = int(cell.max()) + 1
    tone = rng.standard_normal(count).astype(np.float32)
    chance = rng.uniform(0.0, 1.0, count).astype(np.float32)
    return distance * np.float32(LEAVES.texel_m / width_m), tone[cell], chance[cell]


def _shaped(rng: np.random.Generator, spectrum: Floats) -> Floats:
    noise = np.fft.rfft2(rng.standard_normal((TILE_PX, TILE_PX)))
    return np.asarray(np.fft.irfft2(noise * spectrum))


def _levelled(values: Floats) -> NDArray[np.uint8]:
    scaled = (values - values.mean()) / values.std()
    return np.clip(127.5 + 48.0 * scaled, 0.0, 255.0).astype(np.uint8)
