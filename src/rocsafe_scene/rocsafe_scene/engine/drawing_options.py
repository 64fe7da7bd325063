# SPDX-License-Identifier: Apache-2.0
"""Tuning of the engine: levels of detail, resolution of shadows, smoothing of edges."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class DetailOptions:
    """Levels of detail. Distances hold for a camera of `focal_px` and grow with the focal length.

    Chosen so that a change of level moves no edge by more than a pixel.

    Attributes
    ----------
    focal_px
        Focal length for which the distances hold, pixels.
    finest_scale, coarsest_scale
        Limits of the factor on distances for cameras of other focal lengths.
    map_scale
        This factor for pictures without perspective.
    leaves_m, objects_m
        Distances up to which each level of foliage and of other objects is drawn, metres.
    grass_m
        Distances up to which all and half of the long grass is drawn, metres.
    grain_m
        Distances up to which the ground is drawn with and without its grain, metres.
    cells_m
        Simpler meshes keep one corner in each cube of these sizes, metres.
    least_triangles
        Meshes with fewer triangles get no simpler levels.
    near_shadow_m
        The finer shadow map covers this distance from the origin, metres.
    """

    focal_px: float = 1100.0
    finest_scale: float = 0.55
    coarsest_scale: float = 2.0
    map_scale: float = 0.1
    leaves_m: tuple[float, ...] = (62.0, 120.0, 260.0, 9000.0)
    objects_m: tuple[float, ...] = (82.0, 160.0, 320.0, 9000.0)
    grass_m: tuple[float, ...] = (42.0, 80.0)
    grain_m: tuple[float, ...] = (130.0, 9000.0)
    cells_m: tuple[float, ...] = (0.08, 0.16, 0.4)
    least_triangles: int = 60
    near_shadow_m: float = 165.0

    def scale_of(self, focal_px: float) -> float:
        """Return the factor on distances for a camera of a focal length."""
        return min(max(self.focal_px / focal_px, self.finest_scale), self.coarsest_scale)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShadowOptions:
    """Extent and resolution of the maps of shadow and light.

    Attributes
    ----------
    near_m, near_px
        Width of the finer shadow map on the ground, metres, and in texels.
    far_m, far_px
        Width of the coarser shadow map on the ground, metres, and in texels.
    moving_px
        Width in texels of the shadow map of moving objects, which covers `near_m`.
    depth_m
        Extent of the shadow maps along the light, metres.
    canopy_m, canopy_texel_m, canopy_blur_m
        Half extent, texel and blur of the map of the canopy, metres.
    above_m
        Height of cameras that look down on everything, metres.
    sunlit_texel_m
        Texel of the map of light on the inner ground, metres.
    """

    near_m: float = 360.0
    near_px: int = 4096
    far_m: float = 1100.0
    far_px: int = 2048
    moving_px: int = 3072
    depth_m: float = 900.0
    canopy_m: float = 180.0
    canopy_texel_m: float = 0.5
    canopy_blur_m: float = 1.3
    above_m: float = 400.0
    sunlit_texel_m: float = 0.12


@dataclass(frozen=True, slots=True, kw_only=True)
class SmoothingOptions:
    """Edges that are smoothed, after FXAA (Lottes, 2009) but for `least_turn`.

    Attributes
    ----------
    least_contrast, least_contrast_share
        Edges with less contrast than these, in grey levels and relative to the brightness, are
        kept as they are.
    reach_px
        Farthest pixel along an edge that is blended.
    least_turn
        Least step of the third component of a normal that makes an edge within a thing, of 255.
    """

    least_contrast: float = 16.0
    least_contrast_share: float = 0.14
    reach_px: float = 6.0
    least_turn: int = 60


DETAIL = DetailOptions()
SHADOWS = ShadowOptions()
SMOOTHING = SmoothingOptions()
