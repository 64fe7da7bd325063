# SPDX-License-Identifier: Apache-2.0
"""Ground on which a release may still be that nobody has found."""

from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.estimation.found_release import SAMPLES, ReleaseSamples
from rocsafe_dispersion.estimation.release_sampler import Population, ReleaseSampler
from rocsafe_geo.arrays import FloatArray

# Rates of a hidden release, as multiples of the smallest one that matters.
MULTIPLES = (1.0, 4.0, 16.0, 64.0)
# Hypotheses over which the likelihood of one release more is averaged, all places together.
_MOST_TRIED = 10_000
_LARGEST_GAIN = 50.0


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


def hidden_releases(
    sampler: ReleaseSampler, found: Population, places_m: FloatArray, smallest_g_s: float
) -> HiddenReleases:
    """Return what hypotheses say of a release more at each of places (m, 2)."""
    count = len(found.logs)
    repeats = min(max(_MOST_TRIED // len(places_m), 1), count)
    # Each place is tried beside `repeats` hypotheses, spread evenly over all.
    chosen = np.arange(repeats * len(places_m)) % count
    places = np.repeat(places_m, repeats, axis=0)
    rates = smallest_g_s * np.array(MULTIPLES)
    gains = sampler.gains_of_one_more(found, chosen, places, rates)
    weights = np.exp(np.minimum(gains, _LARGEST_GAIN))
    total = np.cumsum(weights.ravel())
    wanted = (np.arange(SAMPLES) + 0.5) / SAMPLES * total[-1]
    drawn = np.minimum(np.searchsorted(total, wanted), total.size - 1)
    rate, trial = np.unravel_index(drawn, weights.shape)
    return HiddenReleases(
        smallest_g_s=smallest_g_s,
        places_m=places_m,
        ratios=weights[0].reshape(len(places_m), repeats).mean(axis=1),
        samples=ReleaseSamples(
            places_m=places[trial],
            rates_g_s=rates[rate],
            shapes=sampler.shapes_of(found.shared[chosen[trial]]),
        ),
    )
