# SPDX-License-Identifier: Apache-2.0
"""All that the adjustment finds: poses, lenses, the ground, and how noisy it all is."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

from rocsafe_mapping.alignment.model.mark import Mark
from rocsafe_mapping.alignment.model.photo import Pose
from rocsafe_mapping.alignment.model.surface import Surface

# Noise of ties that the adjustment begins with.
FIRST_TIE_STD_PX = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Lens:
    """Corrections of a camera.

    Attributes
    ----------
    log_focal
        Natural logarithm of the focal length over what was believed.
    k1, k2
        Radial straightening, see `projection`.
    """

    log_focal: float = 0.0
    k1: float = 0.0
    k2: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """Statistics of the residuals.

    Attributes
    ----------
    tie_std_px
        Of a tie on the ground.
    clutter_std_m
        Of the heights of ties above the ground's surface.
    fix_factor
        Standard deviation of fixes over what they claim.
    mark_factor
        Standard deviation of surveyed marks over `MARK_STD_M`.
    """

    tie_std_px: float = FIRST_TIE_STD_PX
    clutter_std_m: float = 0.0
    fix_factor: float = 1.0
    mark_factor: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """All that the adjustment finds.

    Attributes
    ----------
    poses
        By name of photograph.
    lenses
        By name of lens.
    surface
        Of the ground.
    noise
        Of the residuals.
    marks
        Surveyed points of the ground.
    lifts_m
        By vehicle, how much higher above the ground it flew than it told: heights are often told
        above the place of take-off.
    """

    poses: Mapping[str, Pose]
    lenses: Mapping[str, Lens] = dataclasses.field(default_factory=dict)
    surface: Surface = dataclasses.field(default_factory=Surface)
    noise: Noise = dataclasses.field(default_factory=Noise)
    marks: tuple[Mark, ...] = ()
    lifts_m: Mapping[str, float] = dataclasses.field(default_factory=dict)
