# SPDX-License-Identifier: Apache-2.0
"""Gamma sources."""

import math
from dataclasses import dataclass

from rocsafe_geo.position import GeoPosition

# A hundred thousand times a commercial irradiator of 100 PBq of Co-60 (9.8e6 uSv/s at 1 m); the
# limit keeps every dose rate far below what a float64 can hold.
LARGEST_SIGMA_USVPS = 1e12


@dataclass(frozen=True, slots=True, kw_only=True)
class RadiationSource:
    """A point source of gamma radiation.

    Attributes
    ----------
    name: unique among the sources of a field.
    position: where it is, with its altitude above the ellipsoid.
    sigma_usvps: dose rate at 1 m, microsievert per second; the paper's sigma.
    """

    name: str
    position: GeoPosition
    sigma_usvps: float

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
