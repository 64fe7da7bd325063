# SPDX-License-Identifier: Apache-2.0
"""Ground on which a release may still be that nobody has found."""

from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.estimation.found_release import ReleaseSamples
from rocsafe_geo.arrays import FloatArray

# Rates of a hidden release, as multiples of the smallest one that matters.
HIDDEN_MULTIPLES = np.array([1.0, 4.0, 16.0, 64.0])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class HiddenReleases:
    """What the readings say of a release that was not found.

    Attributes
    ----------
    smallest_g_s
        The smallest rate that matters, g/s.
    places_m : (m, 2)
        Places tried, metres.
    ratios : (m,)
        Likelihood of a release of the smallest rate at each place over that of none, beside
        those that were found.
    samples
        Releases of this rate and above, drawn by their likelihood.
    """

    smallest_g_s: float
    places_m: FloatArray
    ratios: FloatArray
    samples: ReleaseSamples

    @property
    def share(self) -> float:
        """Share of the ground where a release of the smallest rate may be, 0 to 1.

        A place counts by the likelihood ratio, at most as one.
        """
        return float(np.minimum(self.ratios, 1.0).mean())
