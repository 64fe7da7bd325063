# SPDX-License-Identifier: Apache-2.0
"""Filaments: small parcels whose pattern makes the gas that a fast sensor reads come and go.

After Farrell and others 2002 (Environ. Fluid Mech. 2, 143): the mean over time is the plume, and
at one time only a meandering part of it holds gas. A filament leaves the middle of the plume by
a share of the plume's size that stays with it; this share is noise that is correlated over the
times at which filaments leave, so the pattern is carried by the wind (Taylor's hypothesis).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_dispersion.plume.carriers import Carriers, Parcels
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import Travel, at_rows
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between, require_count, require_positive
from rocsafe_geo.wind.wind_field import WindField

_NOISE_BLOCK = 1024
_SCALES_KEPT = 12
# Standard deviations beyond which a filament is not felt.
REACH = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class FilamentOptions:
    """How a plume is cut into filaments.

    Attributes
    ----------
    step_s
        Time between two departures, seconds.
    count
        Filaments that leave at once.
    size_share
        Size of a filament as a share of the plume's vertical size.
    meander_share
        Share of the crosswind variance that all filaments of one time have in common.
    meander_s, eddy_s
        Time scales of the common and of the vertical motion, seconds.
    longest_s
        Age at which filaments are left out, seconds.

    Notes
    -----
    The shares are choices, not measurements: they give intermittency and ratios of peak to mean
    of the order of field experiments (docs/dispersion.md).
    """

    step_s: float = 0.2
    count: int = 4
    size_share: float = 0.35
    meander_share: float = 0.6
    meander_s: float = 5.0
    eddy_s: float = 1.0
    longest_s: float = 600.0

    def __post_init__(self) -> None:
        for name in ('step_s', 'meander_s', 'eddy_s', 'longest_s'):
            require_positive(name, getattr(self, name), 's')
        require_count('count', self.count, 1, 1000)
        require_between('size_share', self.size_share, 0.01, 0.9)
        require_between('meander_share', self.meander_share, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Filaments:
    """Filaments at one time.

    Attributes
    ----------
    middles_m : (n, 3)
        East, north and height above the ground, float32, metres.
    sizes_m : (n,)
        Standard deviation of each along any axis, float32, metres.
    masses_g : (n,)
        Mass of each, float32, g.
    """

    middles_m: NDArray[np.float32]
    sizes_m: NDArray[np.float32]
    masses_g: NDArray[np.float32]

    def concentrations_g_m3(self, places_m: FloatArray) -> FloatArray:
        """Return the concentrations at places (n, 3), heights above the ground, (n,), g/m^3."""
        return np.array([self._concentration(place) for place in places_m.astype(np.float32)])

    def _concentration(self, place: NDArray[np.float32]) -> float:
        offset = self.middles_m[:, :2] - place[:2]
        squares = offset[:, 0] ** 2 + offset[:, 1] ** 2
        near = np.flatnonzero(squares < (REACH * self.sizes_m) ** 2)
        size = self.sizes_m[near].astype(float)
        sum_down = squares[near] + (self.middles_m[near, 2] - place[2]) ** 2
        sum_up = squares[near] + (self.middles_m[near, 2] + place[2]) ** 2
        half = -0.5 / size**2
        shapes = (np.exp(half * sum_down) + np.exp(half * sum_up)) / size**3
        return float(np.dot(shapes, self.masses_g[near]) / (2.0 * math.pi) ** 1.5)


class FilamentCloud:
    """The filaments of one release in any wind; the same at a time in every run of a seed."""

    def __init__(
        self,
        release: Release,
        travel: Travel,
        wind: WindField,
        seed: int,
        options: FilamentOptions | None = None,
    ) -> None:
        self._options = options or FilamentOptions()
        self._release, self._travel = release, travel
        self._seed = require_count('seed', seed, 0, 2**63 - 1)
        self._carriers = Carriers(
            release, travel, wind, self._options.step_s, self._options.longest_s
        )
        self._blocks: dict[int, NDArray[np.float32]] = {}

    def at(self, time_s: float) -> Filaments:
        """Return the filaments at the last whole step before `time_s`."""
        parcels, count = self._carriers.at(time_s), self._options.count
        rows = self._travel.rows(parcels.distances_m)
        sigma_y, sigma_z, middle = (
            at_rows(column, rows)
            for column in (
                self._travel.sigma_y_m,
                self._travel.sigma_z_m,
                self._travel.heights_m(),
            )
        )
        size = np.minimum(self._options.size_share * sigma_z, 0.9 * sigma_y)
        noise = self._noise(parcels)
        across = np.sqrt(sigma_y**2 - size**2).astype(np.float32)[:, None] * noise[:, :, 0]
        up = np.sqrt(sigma_z**2 - size**2).astype(np.float32)[:, None] * noise[:, :, 1]
        heading = parcels.headings.astype(np.float32)
        middles = np.empty((len(rows), count, 3), np.float32)
        middles[:, :, 0] = parcels.places_m[:, :1] - across * heading[:, 1:]
        middles[:, :, 1] = parcels.places_m[:, 1:] + across * heading[:, :1]
        # The ground reflects filaments, so that the mean is that of the plume.
        middles[:, :, 2] = np.abs(middle[:, None] + up)
        return Filaments(
            middles_m=middles.reshape(-1, 3),
            sizes_m=np.repeat(size.astype(np.float32), count),
            masses_g=np.repeat((parcels.masses_g / count).astype(np.float32), count),
        )

    def _noise(self, parcels: Parcels) -> NDArray[np.float32]:
        """Return the shares of the plume's size of each filament, (parcels, count, 2)."""
        if not len(parcels.numbers):
            return np.zeros((0, self._options.count, 2), np.float32)
        first, last = int(parcels.numbers[0]), int(parcels.numbers[-1])
        numbers = range(first // _NOISE_BLOCK, last // _NOISE_BLOCK + 1)
        self._blocks = {one: self._block(one) for one in numbers}
        joined = np.concatenate([self._blocks[one] for one in numbers])
        return np.asarray(joined[parcels.numbers - numbers[0] * _NOISE_BLOCK])

    def _block(self, number: int) -> NDArray[np.float32]:
        """Return the shares of one block of steps, (steps, count, 2)."""
        if number in self._blocks:
            return self._blocks[number]
        options, count = self._options, self._options.count
        warm = min(math.ceil(_SCALES_KEPT * options.meander_s / options.step_s), _NOISE_BLOCK)
        white = np.concatenate([self._white(number - 1)[-warm:], self._white(number)])
        meander = _correlated(white[:, 0], options.step_s / options.meander_s)
        own = _correlated(white[:, 1 : 1 + count], options.step_s / options.eddy_s)
        up = _correlated(white[:, 1 + count :], options.step_s / options.eddy_s)
        share = options.meander_share
        across = math.sqrt(share) * meander[:, None] + math.sqrt(1.0 - share) * own
        return np.stack([across, up], axis=-1)[warm:].astype(np.float32)

    def _white(self, number: int) -> FloatArray:
        # Seeds are not negative; blocks before the start of the mission are odd numbers.
        name = 2 * number if number >= 0 else -2 * number - 1
        generator = np.random.default_rng([self._seed, name])
        return generator.standard_normal((_NOISE_BLOCK, 1 + 2 * self._options.count))


def _correlated(white: FloatArray, step: float) -> FloatArray:
    """Return noise of variance 1 with the correlation exp(-|difference|), from white noise."""
    rho = math.exp(-step)
    found: FloatArray = math.sqrt(1.0 - rho * rho) * white
    for row in range(1, len(found)):
        found[row] += rho * found[row - 1]
    return found
