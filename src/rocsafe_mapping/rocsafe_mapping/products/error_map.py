# SPDX-License-Identifier: Apache-2.0
"""A map of the standard error of each place; objects above the ground are displaced."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from rocsafe_geo.arrays import BoolArray
from rocsafe_geo.storage.durable import write_whole
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_mapping.drawing.coarse_view import NO_PHOTO
from rocsafe_mapping.drawing.placed_photo import Shares
from rocsafe_mapping.drawing.renderer import Renderer
from rocsafe_mapping.mosaic.map_alignment import Alignment
from rocsafe_mapping.products.cog import write_values

ERROR_TIF, ERROR_PNG = 'error.tif', 'error.png'
# Least height of an object that stands on the ground, metres.
STANDING_M = 0.3
LONGEST_SIDE_PX = 1024
# Quantile of the map's errors that gets the brightest colour.
BRIGHTEST = 0.98
UNTOLD_GRAY, UNTOLD_SHARE = 150.0, 0.6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ErrorMap:
    """How far the map may be off, on the renderer's coarse grid, (height, width) each.

    Attributes
    ----------
    error_m
        Standard error of where something is shown, NaN where nothing is.
    heights_m
        Of what is shown above the ground, NaN where unknown.
    ages_s
        How long before the newest photograph that of a place was taken, NaN where unknown.
    """

    error_m: Shares
    heights_m: Shares
    ages_s: Shares

    @property
    def is_shown(self) -> BoolArray:
        """Which places the map shows."""
        shown: BoolArray = np.isfinite(self.error_m)
        return shown

    def facts(self) -> dict[str, Any]:
        """Return the shares of ground, objects and unknown heights, with their errors."""
        is_told = np.isfinite(self.heights_m) & self.is_shown
        is_standing = is_told & (np.abs(np.nan_to_num(self.heights_m)) > STANDING_M)
        kinds = {
            'ground': is_told & ~is_standing,
            'standing': is_standing,
            'untold': self.is_shown & ~is_told,
        }
        shown = max(int(self.is_shown.sum()), 1)
        document: dict[str, Any] = {'rms': self._rms(self.is_shown)}
        for kind, is_kind in kinds.items():
            share = round(float(is_kind.sum()) / shown, 4)
            document[kind] = {'share': share, 'rms': self._rms(is_kind)}
        return document

    def _rms(self, mask: BoolArray) -> float | None:
        if not np.any(mask):
            return None
        return round(float(np.sqrt(np.mean(self.error_m[mask].astype(float) ** 2))), 4)


def error_map(alignment: Alignment, renderer: Renderer) -> ErrorMap:
    """Return how far each place of the map may be off."""
    labels, whole = renderer.owners, renderer.owner_window
    error, ages = (np.full(labels.shape, np.nan, np.float32) for _ in range(2))
    times = {name: alignment.photos[name].time_ns for name in renderer.names}
    newest = max(times.values(), default=0)
    for number, name in enumerate(renderer.names):
        part = renderer.shown_window(name)
        place = part.within(whole)
        is_own = labels[place] == number
        if not np.any(is_own):
            continue
        # The middles of pixels lie between the edges that the lattice has.
        edges = renderer.coarse.ground_lattice(part, 1)
        ground_m = (0.5 * (edges[:-1, :-1] + edges[1:, 1:]))[is_own]
        rise_m = renderer.relief.rise_m[place][is_own].astype(float)
        error[place][is_own] = alignment.errors_at_m(name, ground_m, rise_m)
        if times[name]:
            ages[place][is_own] = (newest - times[name]) / NS_PER_S
    heights = np.where(labels == NO_PHOTO, np.float32(np.nan), renderer.relief.heights_m)
    return ErrorMap(error_m=error, heights_m=heights, ages_s=ages)


def write_error_map(folder: Path, found: ErrorMap, renderer: Renderer) -> str:
    """Write ``error.tif`` and its picture into `folder`; return the picture's name.

    Raises
    ------
    MappingError
        If the GeoTIFF cannot be written.
    OSError
        If the picture cannot be.
    """
    bands = {
        'standard error, m': found.error_m,
        'height above the ground, m': found.heights_m,
        'time before the newest photograph, s': found.ages_s,
    }
    write_values(folder / ERROR_TIF, renderer.coarse, renderer.owner_window, bands)
    write_whole(folder / ERROR_PNG, _png(found))
    return ERROR_PNG


def _png(found: ErrorMap) -> bytes:
    """Return the errors as colours, grey where the height of objects is unknown."""
    most = float(np.quantile(found.error_m[found.is_shown], BRIGHTEST))
    level = np.clip(np.nan_to_num(found.error_m) / max(most, 1e-6), 0.0, 1.0)
    colours = cv2.applyColorMap((255.0 * level).astype(np.uint8), cv2.COLORMAP_INFERNO)
    is_untold = np.isnan(found.heights_m)[..., np.newaxis]
    grayed = UNTOLD_SHARE * colours + (1.0 - UNTOLD_SHARE) * UNTOLD_GRAY
    alpha = np.where(found.is_shown, 255, 0).astype(np.uint8)
    picture = np.dstack([np.where(is_untold, grayed, colours).astype(np.uint8), alpha])
    shrink = max(1, -(-max(alpha.shape) // LONGEST_SIDE_PX))
    return bytes(cv2.imencode('.png', picture[::shrink, ::shrink])[1])
