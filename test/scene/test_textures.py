# SPDX-License-Identifier: Apache-2.0
"""Textures: they tile, use their range evenly, and are the same in every process."""

import numpy as np
import pytest

from rocsafe_scene.mesh.grain import LEAVES, TILE_PX, grain_tile, leaf_tile
from rocsafe_scene.painting.noise import Window
from rocsafe_scene.painting.turf import detail, turf


@pytest.mark.parametrize('channel', range(4))
def test_grain_repeats_without_a_seam(channel):
    """Steps across the border of a tile are those within it, in each direction."""
    tile = grain_tile()[..., channel].astype(float)
    assert tile.shape == (TILE_PX, TILE_PX)
    for axis in (0, 1):
        inside = np.abs(np.diff(tile, axis=axis)).mean()
        first, last = np.take(tile, 0, axis=axis), np.take(tile, -1, axis=axis)
        assert np.abs(first - last).mean() == pytest.approx(inside, rel=0.25)


@pytest.mark.parametrize('tile', [grain_tile, leaf_tile])
def test_textures_have_mean_and_spread_of_their_range(tile):
    """Mean 127.5 and standard deviation 48 of 0 to 255, but for what is cut off."""
    values = tile().reshape(TILE_PX * TILE_PX, -1).astype(float)
    assert values.mean(axis=0) == pytest.approx(127.5, abs=3.0)
    assert values.std(axis=0) == pytest.approx(48.0, abs=4.0)


def test_leaves_are_as_coarse_as_their_sprays():
    """Brightness of neighbours is alike within a spray, and unlike at the width of a bough."""
    tile = leaf_tile().astype(float) - leaf_tile().mean()

    def alike(shift_m):
        shift = round(shift_m / LEAVES.texel_m)
        return float((tile[:, shift:] * tile[:, : tile.shape[1] - shift]).mean() / tile.var())

    assert alike(0.3 * LEAVES.spray_m) > 0.6
    assert alike(2.0 * LEAVES.bough_m) < 0.1


def test_turf_of_neighbouring_windows_fits():
    """A window is the same whether painted alone or as a part of a larger one."""
    whole, part = Window(-40, -30, 60, 50), Window(-10, 0, 20, 30)
    cut = np.s_[0 + 30 : 30 + 30, -10 + 40 : 20 + 40]
    assert (turf(5, 2, whole)[cut] == turf(5, 2, part)).all()
    assert (detail(5, 0, whole)[cut] == detail(5, 0, part)).all()


def test_detail_is_noise_about_zero():
    """Mean near 0, values about -1 to 1 and no larger than the sum of its octaves."""
    found = detail(9, 0, Window(0, 0, 400, 400))
    assert abs(float(found.mean())) < 0.1
    assert 0.2 < float(found.std()) < 1.5
    assert float(np.abs(found).max()) < 6.0
