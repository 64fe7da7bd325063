# SPDX-License-Identifier: Apache-2.0
"""The sources that a survey found, with what is not known of them: `sources.json`."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import GeoPosition
from rocsafe_ground.errors import NoMapError

ROUNDING_M2 = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FoundSource:
    """One source.

    Attributes
    ----------
    position
        Where it was found.
    covariance_m2 : (3, 3)
        Of east, north and up.
    rate_usvh, rate_std_usvh
        Dose rate at 1 m and its standard deviation; its logarithm is taken for normal.
    """

    position: GeoPosition
    covariance_m2: FloatArray
    rate_usvh: float
    rate_std_usvh: float

    def drawn(self, generator: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
        """Return draws: steps east and north from its position, (count, 2), rates, (count,)."""
        steps = generator.multivariate_normal(
            np.zeros(3), self.covariance_m2, count, method='eigh'
        )
        # Variance of the logarithm of a log-normal variable with this relative deviation.
        spread = math.sqrt(math.log1p((self.rate_std_usvh / self.rate_usvh) ** 2))
        return steps[:, :2], self.rate_usvh * np.exp(generator.normal(0.0, spread, count))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SourcePosterior:
    """All sources and the background, microsievert per hour."""

    sources: tuple[FoundSource, ...]
    background_usvh: float
    background_std_usvh: float

    def drawn_background(self, generator: np.random.Generator, count: int) -> FloatArray:
        """Return draws of the background, (count,)."""
        return np.maximum(
            generator.normal(self.background_usvh, self.background_std_usvh, count), 0.0
        )


def read_sources(path: Path) -> SourcePosterior:
    """Return the sources of a file that `rocsafe run` or `rocsafe localize` wrote.

    Raises
    ------
    NoMapError
        If it cannot be read, or holds places without latitude and longitude.
    """
    try:
        document = json.loads(path.read_text(encoding='utf-8'))
        return SourcePosterior(
            sources=tuple(_source(entry) for entry in document['sources']),
            background_usvh=float(document['background_usvh']),
            background_std_usvh=float(document['background_std_usvh']),
        )
    except OSError as error:
        raise NoMapError(f'{path}: {error.strerror}') from error
    except (KeyError, TypeError, ValueError) as error:
        raise NoMapError(f'{path}: is no file of sources of ROCSAFE: {error!r}') from error


def _source(entry: dict[str, Any]) -> FoundSource:
    place = entry['place']
    rate = float(entry['dose_rate_at_1m_usvh'])
    if not rate > 0.0:
        raise ValueError(f'dose_rate_at_1m_usvh is {rate:g}: must be above 0')
    covariance = np.array(entry['position_covariance_m2'], np.float64).reshape(3, 3)
    if not (np.isfinite(covariance).all() and np.linalg.eigvalsh(covariance)[0] > -ROUNDING_M2):
        raise ValueError('position_covariance_m2: must be finite, and no variance below 0')
    return FoundSource(
        position=GeoPosition(place['latitude_deg'], place['longitude_deg'], place['altitude_m']),
        covariance_m2=covariance,
        rate_usvh=rate,
        rate_std_usvh=float(entry['dose_rate_at_1m_std_usvh']),
    )
