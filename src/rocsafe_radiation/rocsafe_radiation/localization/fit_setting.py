# SPDX-License-Identifier: Apache-2.0
"""Setting of a fit: what is fixed while sources and background are fitted."""

from dataclasses import dataclass, field

from rocsafe_radiation.localization.search_options import SearchOptions
from rocsafe_radiation.physics.kernel import Kernel

# The response to a source below is two heights wide at half its maximum, a bump of this spacing
# 3.3 heights.
WIDE_SPACING_HEIGHTS = 2.0
# The edge of a shadow is as wide as a tenth of its distance, so that a fit finds it between
# readings.
SHARP_EDGE = 40.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What is fixed in a fit.

    Attributes
    ----------
    kernel
        Law of the dose rate of all sources.
    source_up_m, source_up_std_m
        Prior of the height of sources above the ground, metres; a standard deviation of 0 fixes
        it.
    background_std
        Prior standard deviation of each coefficient c_j of the background; 0: the background is
        constant.
    background_spacing_heights
        Spacing of the bumps of the background, heights.
    rho
        Share of the excess by which counts scatter beyond Poisson.
    tilt_std
        Prior standard deviation of the tilt of the law of the dose rate; 0: the law is that of the
        kernel.
    has_shield
        Whether a wall may stand on one side of the sources.
    edge_sharpness
        Sharpness of the edge of its shadow; large: a step.
    shade
        Probability that something shields a reading.
    search
        Numbers that tune the search.
    """

    kernel: Kernel = field(default_factory=Kernel)
    source_up_m: float = 0.0
    source_up_std_m: float = 0.0
    background_std: float = 0.0
    background_spacing_heights: float = WIDE_SPACING_HEIGHTS
    rho: float = 0.0
    tilt_std: float = 0.0
    has_shield: bool = False
    edge_sharpness: float = SHARP_EDGE
    shade: float = 0.0
    search: SearchOptions = field(default_factory=SearchOptions)
