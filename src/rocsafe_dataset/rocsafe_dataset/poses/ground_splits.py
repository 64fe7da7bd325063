# SPDX-License-Identifier: Apache-2.0
"""Division of the ground into splits, so that no place is both trained and tested on."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_scene.mesh.mesh import Floats

# Number of blocks in each direction.
BLOCKS = (4, 4)


@dataclass(frozen=True, slots=True, eq=False)
class GroundSplits:
    """The detailed ground in blocks, each given to one split.

    Attributes
    ----------
    half_m
        Half extents of the ground, metres.
    splits : (columns, rows)
        Number of the split of each block.
    """

    half_m: tuple[float, float]
    splits: Floats

    def split_of(self, places: Floats) -> Floats:
        """Return the split of each of `places` (n, 2); -1 off the detailed ground."""
        block = np.floor((places / np.array(self.half_m) + 1.0) * 0.5 * np.array(BLOCKS))
        on = np.all((block >= 0) & (block < np.array(BLOCKS)), axis=1)
        column, row = np.clip(block, 0, np.array(BLOCKS) - 1).astype(int).T
        return np.where(on, self.splits[column, row], -1)

    def blocks_of(self, split: int) -> Floats:
        """Return the south-west corners of the blocks of a split, (n, 2)."""
        corner = np.argwhere(self.splits == split) / np.array(BLOCKS)
        return np.asarray((2.0 * corner - 1.0) * np.array(self.half_m))

    @property
    def block_m(self) -> Floats:
        """Width and height of a block, (2,)."""
        return 2.0 * np.array(self.half_m) / np.array(BLOCKS)


def divide_ground(
    half_m: tuple[float, float], things: Floats, shares: Sequence[float], seed: int
) -> GroundSplits:
    """Give blocks to splits so that each gets its share of the objects and of the ground.

    Parameters
    ----------
    half_m
        Half extents of the ground, metres.
    things : (n, 2)
        East and north of the objects that images are aimed at, metres.
    shares
        Shares of the splits, sum 1; a split with share 0 gets nothing.
    seed
        Seed of the order of equal blocks.
    """
    area = [(-half, half) for half in half_m]
    found = np.histogram2d(things[:, 0], things[:, 1], list(BLOCKS), area)[0]
    weight = found / max(1.0, found.sum()) + 1.0 / found.size
    tie = np.random.default_rng([seed, 11]).permutation(found.size)
    given = np.zeros(BLOCKS, int)
    got = np.zeros(len(shares))
    for block in sorted(range(found.size), key=lambda k: (-weight.flat[k], tie[k])):
        # The block goes to the split that is farthest below its share.
        lack = np.where(np.array(shares) > 0.0, got / np.maximum(shares, 1e-9), np.inf)
        split = int(np.argmin(lack))
        given.flat[block] = split
        got[split] += weight.flat[block]
    return GroundSplits(half_m, given)
