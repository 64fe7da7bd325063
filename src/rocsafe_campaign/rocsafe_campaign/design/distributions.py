# SPDX-License-Identifier: Apache-2.0
"""Distributions that a campaign draws values of scenario keys from."""

import math
from typing import Annotated, Literal, TypeAlias, TypeVar

import numpy as np
import shapely
from pydantic import Field, model_validator
from shapely.geometry import Polygon

from rocsafe_scenario.blocks.block import Block

# Points drawn in the bounds of a polygon until one lies within it; more fail.
MOST_TRIES = 10_000


class Uniform(Block):
    """Between `low` and `high`, all alike."""

    distribution: Literal['uniform']
    low: float
    high: float

    @model_validator(mode='after')
    def _rises(self) -> 'Uniform':
        return _require_rise(self)

    def drawn(self, generator: np.random.Generator, _region: Polygon) -> float:
        """Return a value."""
        return float(generator.uniform(self.low, self.high))


class LogUniform(Block):
    """Between `low` and `high`, all orders of magnitude alike."""

    distribution: Literal['log_uniform']
    low: float = Field(gt=0.0)
    high: float

    @model_validator(mode='after')
    def _rises(self) -> 'LogUniform':
        return _require_rise(self)

    def drawn(self, generator: np.random.Generator, _region: Polygon) -> float:
        """Return a value."""
        return math.exp(generator.uniform(math.log(self.low), math.log(self.high)))


class Normal(Block):
    """Gaussian, cut off at `low` and `high` where they are given."""

    distribution: Literal['normal']
    mean: float
    std: float = Field(gt=0.0)
    low: float | None = None
    high: float | None = None

    @model_validator(mode='after')
    def _can_be_drawn(self) -> 'Normal':
        low, high = self._limits()
        if not low <= self.mean <= high:
            raise ValueError('mean must be between low and high')
        return self

    def _limits(self) -> tuple[float, float]:
        low, high = self.low, self.high
        return -math.inf if low is None else low, math.inf if high is None else high

    def drawn(self, generator: np.random.Generator, _region: Polygon) -> float:
        """Return a value; of those beyond the limits none is taken."""
        low, high = self._limits()
        values = iter(lambda: float(generator.normal(self.mean, self.std)), None)
        return next(value for value in values if low <= value <= high)


class WholeNumber(Block):
    """A whole number from `low` to `high`, both included, all alike."""

    distribution: Literal['whole']
    low: int
    high: int

    @model_validator(mode='after')
    def _rises(self) -> 'WholeNumber':
        return _require_rise(self)

    def drawn(self, generator: np.random.Generator, _region: Polygon) -> int:
        """Return a value."""
        return int(generator.integers(self.low, self.high, endpoint=True))


class Choice(Block):
    """One of `values`, all alike."""

    distribution: Literal['choice']
    values: tuple[float | int | str | bool, ...] = Field(min_length=1)

    def drawn(self, generator: np.random.Generator, _region: Polygon) -> float | int | str | bool:
        """Return a value."""
        return self.values[int(generator.integers(len(self.values)))]


class InRegion(Block):
    """A place in the scenario's region, latitude and longitude, all of its area alike."""

    distribution: Literal['in_region']

    def drawn(self, generator: np.random.Generator, region: Polygon) -> tuple[float, float]:
        """Return a place; `region` has longitudes and latitudes."""
        west, south, east, north = region.bounds
        for _ in range(MOST_TRIES):
            longitude, latitude = generator.uniform((west, south), (east, north)).tolist()
            if shapely.contains_xy(region, longitude, latitude):
                return latitude, longitude
        raise ValueError(f'the region fills less than 1/{MOST_TRIES} of its bounds')


Rising = TypeVar('Rising', Uniform, LogUniform, WholeNumber)
Distribution: TypeAlias = Annotated[
    Uniform | LogUniform | Normal | WholeNumber | Choice | InRegion,
    Field(discriminator='distribution'),
]


def _require_rise(block: Rising) -> Rising:
    if not block.low < block.high:
        raise ValueError('high must be above low')
    return block
