# SPDX-License-Identifier: Apache-2.0
"""The alignment of a map: where all photographs are, and how certain that is."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.height_error import TieHeights, leaning_m
from rocsafe_mapping.alignment.block import BY_GPS, Placement
from rocsafe_mapping.alignment.model.photo import Photo, footprint
from rocsafe_mapping.alignment.model.surface import Surface
from rocsafe_mapping.mosaic.survey import FoundPoint

# Shares of the four corners of a photograph at 8 x 8 places spread over it, shape (64, 4).
_ALONG = (np.arange(8) + 0.5) / 8
EVENLY = np.stack(
    [np.outer(a, b).ravel() for a, b in (
        (1 - _ALONG, 1 - _ALONG), (1 - _ALONG, _ALONG), (_ALONG, _ALONG), (_ALONG, 1 - _ALONG)
    )], axis=1,
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Alignment:
    """Places of all photographs, with their uncertainty.

    Attributes
    ----------
    photos, placements
        By name.
    errors_m
        Standard error of each tied photograph's corners on level ground.
    held_out_px
        Residuals (n, 2) of ties that were not adjusted.
    heights
        How high the points of ties stand above the ground.
    heights_error
        Standard error of the ground's heights with what stands there.
    lags_s
        By how much the fixes of vehicles are late, where that is certain; the priors of `photos`
        are without it.
    groups
        Numbers of photographs that are tied to each other, largest first.
    control
        Surveyed points of the ground.
    is_local
        Whether the map has neither scale nor north.
    """

    photos: Mapping[str, Photo]
    placements: Mapping[str, Placement]
    errors_m: Mapping[str, float]
    held_out_px: FloatArray
    heights: TieHeights
    heights_error: Surface = field(default_factory=Surface)
    lags_s: Mapping[str, float] = field(default_factory=dict)
    groups: tuple[int, ...] = ()
    control: tuple[FoundPoint, ...] = ()
    is_local: bool = False

    def error_m(self, name: str, ground_m: FloatArray | None = None) -> float:
        """Return the standard error of the ground that a photograph shows, or of points (n, 2)."""
        if ground_m is None:
            ground_m = EVENLY @ footprint(self.photos[name], self.placements[name].pose)
        return float(np.sqrt(np.mean(self.errors_at_m(name, ground_m) ** 2)))

    def errors_at_m(
        self, name: str, ground_m: FloatArray, rise_m: FloatArray | float = 0.0
    ) -> FloatArray:
        """Return the standard errors (n,) of what a photograph shows at points (n, 2) of the map.

        `rise_m` is the height above the ground of what it shows there: a flat map shows it
        displaced.
        """
        pose = self.placements[name].pose
        leaning = leaning_m(self.heights_error, pose, ground_m, rise_m)
        return np.hypot(self._placing_error_m(name), leaning)

    def _placing_error_m(self, name: str) -> float:
        """Return the standard error of a photograph's corners if the ground were as found."""
        if name in self.errors_m:
            return self.errors_m[name]
        photo = self.photos[name]
        height_m = float(photo.prior.centre[2])
        turn = photo.tilt_std_rad * math.sqrt(2.0)
        yaw = photo.yaw_std_rad if photo.has_yaw else math.pi / 2
        side_m = 0.5 * math.hypot(photo.camera.width_px, photo.camera.height_px)
        side_m *= photo.ground_resolution_m
        return math.hypot(photo.horizontal_std_m * math.sqrt(2.0), turn * height_m, yaw * side_m)


def by_gps(alignment: Alignment) -> tuple[str, ...]:
    """Return the names of the photographs that only their fixes place."""
    return tuple(sorted(n for n, p in alignment.placements.items() if p.placed_by == BY_GPS))
