# SPDX-License-Identifier: Apache-2.0
"""Random errors as functions of seed, vehicle, stream, and time or number.

No generator is kept between calls. Errors depend neither on the order of calls nor on the speed of
a run, and a restarted process repeats them.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from zlib import crc32

import numpy as np

Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Draws:
    """Standard normal values of one vehicle, three for each stream and number.

    Attributes
    ----------
    seed
        Seed of the run, 0 or above.
    vehicle
        Name of the vehicle.
    """

    seed: int
    vehicle: str

    def white(self, stream: int, index: int) -> Triple:
        """Return values that are independent for each index."""
        return _normals(self.seed, self.vehicle, stream, index)

    def knot(self, stream: int, index: int) -> Triple:
        """Return values as `white`; the last ones asked for are kept."""
        return _kept_normals(self.seed, self.vehicle, stream, index)

    def drift(self, stream: int, time_ns: int, period_ns: int) -> Triple:
        """Return values that vary slowly with time, standard normal at each time.

        Values at multiples of `period_ns` are blended by cosine and sine, whose squares add up
        to 1.
        """
        number, rest_ns = divmod(time_ns, period_ns)
        turn = 0.5 * math.pi * rest_ns / period_ns
        early, late = math.cos(turn), math.sin(turn)
        before, after = self.knot(stream, number), self.knot(stream, number + 1)
        x, y, z = (early * a + late * b for a, b in zip(before, after, strict=True))
        return x, y, z


@dataclass(frozen=True, slots=True, kw_only=True)
class ErrorModel:
    """Error of a sensor with up to three axes: a white part and one that drifts.

    Attributes
    ----------
    white_std
        Standard deviation of the part that is new in each sample.
    drift_std
        Standard deviation of the part that varies slowly.
    drift_period_ns
        Values of the drift further apart than two periods are independent.
    streams
        Numbers of the streams of both parts; no other error of a vehicle has them.
    """

    white_std: float
    drift_std: float
    drift_period_ns: int
    streams: tuple[int, int]

    @property
    def variance(self) -> float:
        """Variance of the whole error on each axis."""
        return self.white_std**2 + self.drift_std**2

    def at(self, draws: Draws, time_ns: int) -> Triple:
        """Return the error of a sample on each axis."""
        white = draws.white(self.streams[0], time_ns)
        drift = draws.drift(self.streams[1], time_ns, self.drift_period_ns)
        x, y, z = (
            self.white_std * a + self.drift_std * b for a, b in zip(white, drift, strict=True)
        )
        return x, y, z


def _normals(seed: int, vehicle: str, stream: int, index: int) -> Triple:
    """Return three standard normal values that depend on these arguments only."""
    generator = np.random.default_rng([seed, crc32(vehicle.encode()), stream, index])
    x, y, z = generator.standard_normal(3).tolist()
    return x, y, z


# Two knots of each slow error of a large fleet.
_kept_normals = lru_cache(maxsize=4096)(_normals)
