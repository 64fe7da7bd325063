# SPDX-License-Identifier: Apache-2.0
"""What is held fixed while sources and background are fitted."""

from dataclasses import dataclass, field

from rocsafe_radiation.physics.kernel import Kernel

# A source seen from above is two heights wide at half its maximum, a bump of this spacing 3.3.
WIDE_SPACING_HEIGHTS = 2.0
# An edge of a shadow is as wide as a tenth of its distance: fits still find it between readings.
SHARP_EDGE = 40.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Setting:
    """What is held fixed in a fit.

    Attributes
    ----------
    kernel
        Of all sources.
    source_up_m, source_up_std_m
        Height of sources above the ground as known before; a standard deviation of 0 keeps it.
    background_std
        Of each c_j as known before; 0: the background is the same everywhere.
    background_spacing_heights
        Of the bumps of the background, in heights above the ground.
    rho
        Share of the excess by which counts scatter beyond Poisson.
    tilt_std
        Of the number of the deviation of the law of the dose rate as known before; 0: it is that
        of the kernel.
    has_shield
        Something may stand on one side of the sources.
    edge_sharpness
        Of what it hides; large: a step.
    shade
        Probability that something shields a reading.
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
