# SPDX-License-Identifier: Apache-2.0
"""What something with a wall and a roof takes of the dose rate of a source beside it.

A tank car or a house stands on one side, so that readings there get less, but for those so far
above or aside that they look past it. It hides what lies beyond the line l x = 1, with x the
horizontal way from source to reading in heights, and no farther aside than G times the way y
across the wall, of x along l: p = 1 / (1 + exp(z (1 - l x))) / (1 + (u / G y)^20), with u the way
along the wall; nearly steps both.

A ray goes in through the wall and out through the roof. The way in the wall is the longer the
steeper and the more aslant it comes, in the roof the flatter it is: k = e^w (d / y + d / h)^c at
the distance d, from h above, with c = 1 but for shapes of other kinds: a row of trees takes the
same of all, c = 0. Of k mean free paths scatter makes up for 1 + k (linear build-up), so that the
logarithm of what is taken is p (k - log(1 + k)).

Five numbers: l, east and north; w, log G and c beyond the usual, e^w the thickness of wall and
roof in mean free paths.
"""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray

# Standard deviations of the numbers as known before: what stands beside a source and is three
# times as high hides it from readings beyond a third of the height.
SHIELD_STDS = (3.5, 3.5, 1.5, 1.0, 0.5)
# Where among the numbers of a law the line of the shield is.
LINE = slice(-5, -3)
USUAL_LOG_DEPTH, USUAL_LOG_REACH, USUAL_POWER = -0.5, 1.5, 1.0
LARGEST_LOG = 30.0
END_POWER = 20.0
LARGEST_ASIDE = 4.0
# Nearer than so many heights, a ray goes over a wall of any height that stands there.
STEEPEST_HEIGHTS = 0.1
# Below this, the direction of a line means nothing.
SHORTEST_LINE = 0.3
# Nearer to the middle, no end is felt.
SHORTEST_WAY_M = 1e-6


class WallShadow:
    """What each ray loses, and how that changes.

    Attributes
    ----------
    losses
        The logarithm of what is taken, shape (sources, n).
    by_depth, by_reach, by_shape
        How that grows with w, log G and c, (sources, n).
    by_distance
        With the distance, the ways east and north unchanged, 1/m, (sources, n).
    """

    def __init__(
        self, numbers: FloatArray, offsets: FloatArray, height_m: float, edge_sharpness: float
    ) -> None:
        self._line = numbers[:2]
        self._turned = np.array([-self._line[1], self._line[0]])
        self._size = math.hypot(*self._line, SHORTEST_LINE)
        self._across, self._along = (
            np.einsum('c,kcn->kn', way / self._size, offsets[:, :2])
            for way in (self._line, self._turned)
        )
        beyond = edge_sharpness * (self._across * self._size / height_m - 1.0)
        before = 1.0 / (1.0 + np.exp(np.clip(beyond, -LARGEST_LOG, LARGEST_LOG)))
        ways = np.hypot(self._across, STEEPEST_HEIGHTS * height_m)
        aside = self._aside(math.exp(USUAL_LOG_REACH + numbers[3]) * ways)
        distances = np.sqrt(np.einsum('kcn,kcn->kn', offsets, offsets))
        slants = 1.0 / ways + 1.0 / height_m
        power = USUAL_POWER + numbers[4]
        logs = np.log(distances * slants)
        depths = np.exp(USUAL_LOG_DEPTH + numbers[2] + power * logs)
        share = (1.0 - before) * (1.0 - aside)
        self.losses = share * (depths - np.log1p(depths))
        self.by_depth = share * depths * depths / (1.0 + depths)
        self.by_reach = END_POWER * aside * self.losses
        self.by_shape = self.by_depth * logs
        self.by_distance = self.by_depth * power / distances
        self._edges = self.losses * before * edge_sharpness / height_m
        # The farther across, the less slanted it meets the wall, and the farther reaches this.
        steepness = power * self.by_depth / slants / ways
        self._by_across = (self.by_reach - steepness) * self._across / ways**2
        is_aside = np.abs(self._along) > SHORTEST_WAY_M
        self._by_along = -self.by_reach / np.where(is_aside, self._along, np.inf)

    def by_line(self, offsets: FloatArray) -> FloatArray:
        """Return how the losses change with both numbers of the line, (2, sources, n)."""
        east, north = offsets[:, 0], offsets[:, 1]
        shrinks = self._by_across * self._across + self._by_along * self._along
        turns = (
            self._by_across * east + self._by_along * north,
            self._by_across * north - self._by_along * east,
        )
        return np.stack(
            [
                self._edges * way + turn / self._size - part / self._size**2 * shrinks
                for way, turn, part in zip((east, north), turns, self._line, strict=True)
            ]
        )

    def by_way(self) -> FloatArray:
        """Return how they change with the way east and north, (sources, 2, n)."""
        forward = (self._edges + self._by_across / self._size)[:, None]
        sideways = (self._by_along / self._size)[:, None]
        return np.asarray(self._line[:, None] * forward + self._turned[:, None] * sideways)

    def _aside(self, reaches_m: FloatArray) -> FloatArray:
        """Return how far each ray passes beyond an end, 0 to 1."""
        ratios = np.minimum(np.abs(self._along) / reaches_m, LARGEST_ASIDE) ** END_POWER
        return np.asarray(ratios / (1.0 + ratios))
