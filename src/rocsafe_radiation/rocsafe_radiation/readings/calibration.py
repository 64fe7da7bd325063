# SPDX-License-Identifier: Apache-2.0
"""How a detector makes dose rates of its counts, from what it tells of both."""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray

# Dose rates are made of the counts if half of them differ by less than so many Poisson errors of
# these: what rounding adds to their variance is then small. Dose rates from elsewhere differ by
# 0.67 (the median of a Gaussian).
LARGEST_MISS = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Calibration:
    """The law counts = live time (sensitivity x dose rate + dark rate).

    Attributes
    ----------
    sensitivity_cps_per_usvh
        Counts a second for 1 uSv/h; 0: not known.
    dark_rate_cps
        Counts a second without radiation; 0 where dose rates do not follow the law.
    """

    sensitivity_cps_per_usvh: float = 0.0
    dark_rate_cps: float = 0.0

    def agrees(
        self, counts: FloatArray, live_s: FloatArray, dose_rates_usvh: FloatArray
    ) -> BoolArray:
        """Return which readings follow the law to the tolerance above, shape (n,)."""
        told = live_s * (self.sensitivity_cps_per_usvh * dose_rates_usvh + self.dark_rate_cps)
        return np.asarray(np.abs(counts - told) <= LARGEST_MISS * np.sqrt(counts), dtype=bool)


def calibration_of(
    counts: FloatArray, live_s: FloatArray, dose_rates_usvh: FloatArray
) -> Calibration:
    """Return the calibration of one detector from its readings, all arrays of shape (n,).

    A line through count rates and dose rates by Theil's incomplete method (1950), which few wrong
    rows do not change: the median slope of pairs half of all ranks apart. Dose rates of 0 tell
    nothing: they stand for fewer counts than dark ones, too.
    """
    with np.errstate(invalid='ignore'):
        known = (counts > 0.0) & (live_s > 0.0) & (dose_rates_usvh > 0.0)
    if not known.any():
        return Calibration()
    counts, live_s, rates = counts[known], live_s[known], dose_rates_usvh[known]
    counted = counts / live_s
    order = np.argsort(counted, kind='stable')
    half = len(order) - len(order) // 2
    low, high = order[: len(order) - half], order[half:]
    apart = counted[high] > counted[low]
    slopes = (rates[high] - rates[low])[apart] / (counted[high] - counted[low])[apart]
    slope = float(np.median(slopes)) if slopes.size else 0.0
    if slope > 0.0:
        dark_cps = max(0.0, float(np.median(counted - rates / slope)))
        found = Calibration(sensitivity_cps_per_usvh=1.0 / slope, dark_rate_cps=dark_cps)
        if np.mean(found.agrees(counts, live_s, rates)) >= 0.5:
            return found
    return Calibration(sensitivity_cps_per_usvh=float(np.median(counted / rates)))
