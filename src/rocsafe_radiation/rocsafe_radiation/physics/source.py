# SPDX-License-Identifier: Apache-2.0
"""Gamma sources."""

import math
from dataclasses import dataclass

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.physics.nuclide import DEFAULT_NUCLIDE, nuclide
from rocsafe_radiation.physics.source_shape import PointShape, SourceShape

# 100,000 times a commercial irradiator of 100 PBq of Co-60 (9.8e6 uSv/s at 1 m); the limit keeps
# every dose rate finite.
LARGEST_SIGMA_USVPS = 1e12


@dataclass(frozen=True, slots=True, kw_only=True)
class RadiationSource:
    """A source of gamma radiation.

    Attributes
    ----------
    name
        Unique among the sources of a field.
    position
        Where it is, or begins, with its altitude above the ellipsoid.
    sigma_usvps
        Dose rate at 1 m without air, microsievert per second; the paper's sigma. For a source that
        is not a point: that of all of it in one point.
    nuclide
        What it consists of; by default Cs-137. The model ``paper`` ignores it.
    shape
        Where its parts are at any time; None: all at `position`, always.
    """

    name: str
    position: GeoPosition
    sigma_usvps: float
    nuclide: str = DEFAULT_NUCLIDE
    shape: SourceShape | None = None

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError('source name must not be empty')
        if not math.isfinite(self.position.altitude_m):
            raise ValueError(f'source {self.name}: altitude_m must be finite')
        if not 0.0 < self.sigma_usvps <= LARGEST_SIGMA_USVPS:
            raise ValueError(
                f'source {self.name}: sigma_usvps = {self.sigma_usvps} must be above 0 and '
                f'at most {LARGEST_SIGMA_USVPS:g}'
            )
        try:
            nuclide(self.nuclide)
        except ValueError as error:
            raise ValueError(f'source {self.name}: {error}') from error

    def places(self, time_s: float = 0.0) -> FloatArray:
        """Return latitude, longitude, altitude of each of its equal parts, shape (parts, 3)."""
        return (self.shape or PointShape(place=self.position)).places(time_s)


def decayed_sigma_usvps(name: str, nuclide_name: str, activity_gbq: float, age_s: float) -> float:
    """Return the dose rate at 1 m of source `name`, uSv/s, `age_s` after it had `activity_gbq`.

    Raises
    ------
    ValueError
        Naming the source, the value and the limit.
    """
    if not 0.0 < activity_gbq < math.inf:
        raise ValueError(
            f'source {name}: activity_gbq = {activity_gbq} must be above 0 and finite'
        )
    if not math.isfinite(age_s):
        raise ValueError(f'source {name}: age_s = {age_s} must be finite')
    try:
        kind = nuclide(nuclide_name)
    except ValueError as error:
        raise ValueError(f'source {name}: {error}') from error
    return kind.sigma_usvps(activity_gbq, age_s)
