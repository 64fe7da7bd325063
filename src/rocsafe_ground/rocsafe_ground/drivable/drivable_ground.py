# SPDX-License-Identifier: Apache-2.0
"""Which cells can be driven, how fast, and what keeps the others from it.

What was not seen is not free. Obstacles grow by half the width of the vehicle and a margin.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum

import numpy as np
import shapely
from rasterio.enums import Resampling
from scipy.ndimage import distance_transform_edt, label

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_ground.drivable.contrast import ContrastRules, is_unlike
from rocsafe_ground.drivable.ground_classes import ColourRules, GroundClass, ground_classes
from rocsafe_ground.drivable.labels import LabelMap
from rocsafe_ground.drivable.raster import Bands
from rocsafe_ground.drivable.relief import Relief, relief_of
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.drivable.things import PART_M, distances_m, in_cells, parts_of, thing_parts
from rocsafe_ground.drivable.vehicle import GroundVehicle

IntArray = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]
DRIVEN = (GroundClass.ROAD, GroundClass.GRASS, GroundClass.SOIL)
OPAQUE = 128.0


class Reason(IntEnum):
    """State of a cell: free, or the first of these reasons that keeps a vehicle out."""

    FREE = 0
    UNKNOWN = 1
    KEEP_OUT = 2
    OBSTACLE = 3
    STEEP = 4
    ROUGH = 5
    TOO_NEAR = 6
    HOT = 7
    GASSED = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundRules:
    """How products become drivable ground.

    Attributes
    ----------
    colours, contrast
        Limits of the classes of colours, and of what is unlike its surroundings.
    least_seen
        Share of a cell that photographs must show.
    most_blocked
        Share of a square of 0.5 m that may look like something else than ground: markings of a
        road and noise of the colours are less.
    least_height_m
        Height above the ground that is more than the noise of heights from photographs.
    roughest_share
        Standard deviation of heights about their plane, as a share of the largest step, above
        which ground is too rough: what sticks out of it is up to four times as high.
    least_roughness_m
        Less is the noise of a good elevation model.
    slowest_share
        Share of its speed that a vehicle keeps on the steepest or roughest ground it can drive.
    least_patch_m2
        A patch of grey or brown that is smaller is a thing, not ground: vehicles, tanks and roofs
        of sheds are up to 80 m2.
    """

    colours: ColourRules = field(default_factory=ColourRules)
    contrast: ContrastRules = field(default_factory=ContrastRules)
    least_seen: float = 0.9
    most_blocked: float = 0.35
    least_height_m: float = 0.5
    roughest_share: float = 0.25
    least_roughness_m: float = 0.01
    slowest_share: float = 0.4
    least_patch_m2: float = 80.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrivableGround:
    """Ground on which a vehicle can drive.

    Attributes
    ----------
    reasons : (rows, columns)
        `Reason` of each cell.
    slowness_spm : (rows, columns)
        Seconds a metre; infinite where no speed is known.
    ages_s : (rows, columns)
        How long before the newest photograph a cell was photographed, NaN where that is not
        known; None: nowhere.
    """

    reasons: IntArray
    slowness_spm: FloatArray
    ages_s: FloatArray | None = None

    @property
    def is_free(self) -> BoolArray:
        """Whether the middle of the vehicle may be in a cell, (rows, columns)."""
        return np.asarray(self.reasons == Reason.FREE)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Layers:
    """What is known of the ground, all but the mosaic optional.

    Attributes
    ----------
    mosaic
        Red, green, blue and opacity, 0 to 255.
    labels
        Classes that somebody or something labelled: they count instead of colours.
    heights
        Height of things above the ground, one band, metres.
    ages
        How long before the newest photograph a pixel was photographed, one band, seconds.
    terrain
        Elevation model.
    keep_outs
        Zones not to be entered, east and north.
    """

    mosaic: Bands
    labels: LabelMap | None = None
    heights: Bands | None = None
    ages: Bands | None = None
    terrain: Terrain | None = None
    keep_outs: Sequence[shapely.Polygon] = ()


def drivable_ground(
    layers: Layers, grid: RouteGrid, vehicle: GroundVehicle, rules: GroundRules | None = None
) -> DrivableGround:
    """Return where `vehicle` can drive on `grid`."""
    rules = rules or GroundRules()
    classes = _classes(layers, rules.colours)
    driven, seen = _class_shares(classes, grid)
    parts = _things(layers, classes, grid, vehicle, rules)
    reasons = np.full(grid.shape, Reason.FREE, np.uint8)
    relief = relief_of(layers.terrain, grid, vehicle)
    is_steep = relief.slope_rad > math.radians(vehicle.largest_slope_deg)
    reasons[relief.roughness_m > _roughest_m(vehicle, rules)] = Reason.ROUGH
    reasons[is_steep | relief.is_step] = Reason.STEEP
    if layers.labels is None:
        reasons[_is_small_patch(driven, in_cells(parts, grid), grid, rules)] = Reason.OBSTACLE
    for zone in layers.keep_outs:
        east, north = grid.places()
        reasons[shapely.contains_xy(zone.buffer(0.5 * grid.cell_m), east, north)] = Reason.KEEP_OUT
    reasons[(seen < rules.least_seen) | np.isnan(relief.slope_rad)] = Reason.UNKNOWN
    kept_m = vehicle.kept_m(grid.cell_m)
    near = is_near(reasons != Reason.FREE, grid.cell_m, kept_m)
    near |= distances_m(parts, grid) < kept_m
    is_free = reasons == Reason.FREE
    reasons[is_free & near] = Reason.TOO_NEAR
    reasons[is_free & in_cells(parts, grid)] = Reason.OBSTACLE
    return DrivableGround(
        reasons=reasons,
        slowness_spm=_slowness(driven, relief, vehicle, rules),
        ages_s=_ages(layers, grid),
    )


def _classes(layers: Layers, rules: ColourRules) -> Bands:
    """Return the class of each pixel by its label, else by its colour; 0 where unknown."""
    if layers.labels is not None:
        pixels, classes = layers.labels.bands, layers.labels.classes()
    else:
        pixels = layers.mosaic
        red, green, blue, opacity = pixels.values[:4]
        classes = np.where(opacity >= OPAQUE, ground_classes(red, green, blue, rules), 0.0)
    return replace(pixels, values=classes[None].astype(np.float32))


def _class_shares(classes: Bands, grid: RouteGrid) -> tuple[FloatArray, FloatArray]:
    """Return the share of each driven class, and of what was seen, in each cell."""
    values = classes.values[0]
    shown = np.stack([*(values == kind for kind in DRIVEN), values > 0.0]).astype(np.float32)
    # Pixels finer than cells are averaged; the nearest of coarser ones counts.
    how = Resampling.average if classes.pixel_m < grid.cell_m else Resampling.nearest
    found = np.nan_to_num(replace(classes, values=shown).on(grid, how))
    return found[:-1], found[-1]


def _things(
    layers: Layers, classes: Bands, grid: RouteGrid, vehicle: GroundVehicle, rules: GroundRules
) -> BoolArray:
    """Return which parts of cells are covered by what looks like a thing, or is higher.

    A thing looks like something else than ground, or unlike the ground around it.
    """
    values = classes.values[0]
    is_odd = values > max(DRIVEN)
    # A small thing has too few pixels to stand out where they are coarser.
    if layers.labels is None and classes.pixel_m < PART_M:
        colours, is_seen = layers.mosaic.values[:3], values > 0.0
        is_odd |= is_unlike(colours, is_seen, classes.pixel_m, rules.contrast)
    looks = np.stack([is_odd, values > 0.0]).astype(np.float32)
    parts = thing_parts(replace(classes, values=looks), grid, rules.most_blocked)
    if layers.heights is not None:
        # A part is as high as the highest thing in it.
        tall = layers.heights.on(grid, Resampling.max, parts_of(grid))[0]
        parts |= tall >= max(rules.least_height_m, vehicle.largest_step_m)
    return parts


def _is_small_patch(
    driven: FloatArray, is_blocked: BoolArray, grid: RouteGrid, rules: GroundRules
) -> BoolArray:
    """Return which cells are in patches of grey or brown that are too small to be ground."""
    kinds = driven.argmax(axis=0)
    found = np.zeros(grid.shape, np.bool_)
    for kind in (DRIVEN.index(GroundClass.ROAD), DRIVEN.index(GroundClass.SOIL)):
        patches, _ = label((kinds == kind) & ~is_blocked & (driven[kind] > 0.0))
        area = np.bincount(patches.ravel()) * grid.cell_m**2
        is_small = area < rules.least_patch_m2
        is_small[0] = False
        found |= is_small[patches]
    return found


def is_near(is_blocked: BoolArray, cell_m: float, reach_m: float) -> BoolArray:
    """Return which cells are within `reach_m` of a blocked cell or of the edge of the grid."""
    around = np.pad(is_blocked, 1, constant_values=True)
    # Distances are between middles of cells; an obstacle begins half a cell nearer.
    distance = distance_transform_edt(~around)[1:-1, 1:-1] * cell_m - 0.5 * cell_m
    return np.asarray(distance < reach_m)


def _roughest_m(vehicle: GroundVehicle, rules: GroundRules) -> float:
    """Return the roughness above which ground is not driven."""
    return max(rules.roughest_share * vehicle.largest_step_m, rules.least_roughness_m)


def _ages(layers: Layers, grid: RouteGrid) -> FloatArray | None:
    # A cell that several photographs show is as old as its oldest part.
    return None if layers.ages is None else layers.ages.on(grid, Resampling.max)[0]


def _slowness(
    driven: FloatArray, relief: Relief, vehicle: GroundVehicle, rules: GroundRules
) -> FloatArray:
    """Return seconds a metre by the commonest class of each cell, its slope and roughness."""
    speeds = np.array([vehicle.road_mps, vehicle.grass_mps, vehicle.rough_mps])
    speed = np.where(driven.max(axis=0) > 0.0, speeds[driven.argmax(axis=0)], 0.0)
    steepest = max(math.radians(vehicle.largest_slope_deg), 1e-9)
    effort = np.maximum(
        relief.slope_rad / steepest, relief.roughness_m / _roughest_m(vehicle, rules)
    )
    share = 1.0 - (1.0 - rules.slowest_share) * np.clip(effort, 0.0, 1.0)
    with np.errstate(divide='ignore'):
        return np.asarray(1.0 / (speed * share))
