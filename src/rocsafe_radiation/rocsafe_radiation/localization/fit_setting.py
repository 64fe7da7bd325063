# SPDX-License-Identifier: Apache-2.0
"""Setting of a fit: what is fixed while sources and background are fitted."""

from dataclasses import dataclass, field

from rocsafe_radiation.localization.search_options import SearchOptions
from rocsafe_radiation.physics.kernel import Kernel


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
    position_std_m
        Standard deviation of each coordinate of the fixes, metres.
    drift_std_m
        Standard deviation of what these errors have in common over each leg of the flight; 0:
        nothing.
    background_std
        Prior standard deviation of each coefficient of the background's random field; 0: it has
        none.
    background_spacing_heights
        Spacing of its bumps, heights.
    rho
        Share of the dose rate of the sources by which readings scatter beyond their counts.
    has_shades
        Whether something beside each source may take part of its dose rate on one side.
    search
        Numbers that tune the search.
    """

    kernel: Kernel = field(default_factory=Kernel)
    source_up_m: float = 0.0
    source_up_std_m: float = 0.0
    position_std_m: float = 0.0
    drift_std_m: float = 0.0
    background_std: float = 0.0
    background_spacing_heights: float = 2.0
    rho: float = 0.0
    has_shades: bool = False
    search: SearchOptions = field(default_factory=SearchOptions)
