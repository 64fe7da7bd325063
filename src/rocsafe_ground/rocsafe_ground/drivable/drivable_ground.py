# SPDX-License-Identifier: Apache-2.0
"""Which cells can be driven, how fast, and what keeps the others from it.

What was not seen is not free. Obstacles grow by half the width of the vehicle and a margin.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
import shapely
from rasterio.enums import Resampling
from scipy.ndimage import distance_transform_edt, label

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.terrain.terrain import Terrain
from rocsafe_ground.drivable.ground_classes import ColourRules, GroundClass, ground_classes
from rocsafe_ground.drivable.labels import LabelMap
from rocsafe_ground.drivable.raster import Bands
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.drivable.vehicle import GroundVehicle

IntArray = np.ndarray[tuple[int, ...], np.dtype[np.uint8]]
DRIVEN = (GroundClass.ROAD, GroundClass.GRASS, GroundClass.SOIL)
OPAQUE = 128.0


class Reason(IntEnum):
    """What a cell is: free, or why not; the first of these that holds."""

    FREE = 0
    UNKNOWN = 1
    KEEP_OUT = 2
    OBSTACLE = 3
    STEEP = 4
    TOO_NEAR = 5
    HOT = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundRules:
    """How products become drivable ground.

    Attributes
    ----------
    colours
        Limits of the classes of colours.
    least_seen
        Share of a cell that photographs must show.
    most_blocked
        Share of a cell that may look like something else than ground: markings of a road and
        noise of the colours are less.
    least_height_m
        Height above the ground that is more than the noise of heights from photographs.
    slowest_on_slope
        Share of its speed that a vehicle keeps on the steepest slope it can climb.
    least_patch_m2
        A patch of grey or brown that is smaller is a thing, not ground: vehicles, tanks and roofs
        of sheds are up to 80 m2.
    """

    colours: ColourRules = field(default_factory=ColourRules)
    least_seen: float = 0.9
    most_blocked: float = 0.35
    least_height_m: float = 0.5
    slowest_on_slope: float = 0.4
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
    """

    reasons: IntArray
    slowness_spm: FloatArray

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
    terrain
        Elevation model.
    keep_outs
        Zones not to be entered, east and north.
    """

    mosaic: Bands
    labels: LabelMap | None = None
    heights: Bands | None = None
    terrain: Terrain | None = None
    keep_outs: Sequence[shapely.Polygon] = ()


def drivable_ground(
    layers: Layers, grid: RouteGrid, vehicle: GroundVehicle, rules: GroundRules | None = None
) -> DrivableGround:
    """Return where `vehicle` can drive on `grid`."""
    rules = rules or GroundRules()
    shares = _class_shares(layers, grid, rules.colours)
    driven = shares[: len(DRIVEN)]
    seen, blocked = shares[-1], shares[-2]
    reasons = np.full(grid.shape, Reason.FREE, np.uint8)
    slope, is_step = _slope(layers.terrain, grid, vehicle)
    reasons[(slope > math.radians(vehicle.largest_slope_deg)) | is_step] = Reason.STEEP
    is_blocked = blocked > rules.most_blocked * seen
    if layers.labels is None:
        is_blocked |= _is_small_patch(driven, is_blocked, grid, rules)
    reasons[is_blocked] = Reason.OBSTACLE
    if layers.heights is not None:
        # A cell is as high as the highest thing in it.
        tall = layers.heights.on(grid, Resampling.max)[0]
        reasons[tall >= max(rules.least_height_m, vehicle.largest_step_m)] = Reason.OBSTACLE
    for zone in layers.keep_outs:
        east, north = grid.places()
        reasons[shapely.contains_xy(zone.buffer(0.5 * grid.cell_m), east, north)] = Reason.KEEP_OUT
    reasons[(seen < rules.least_seen) | np.isnan(slope)] = Reason.UNKNOWN
    near = _is_near(reasons != Reason.FREE, grid.cell_m, vehicle.reach_m)
    reasons[near & (reasons == Reason.FREE)] = Reason.TOO_NEAR
    return DrivableGround(reasons=reasons, slowness_spm=_slowness(driven, slope, vehicle, rules))


def _class_shares(layers: Layers, grid: RouteGrid, rules: ColourRules) -> FloatArray:
    """Return the share of each driven class, of all others, and of what was seen, in each cell."""
    if layers.labels is not None:
        pixels = layers.labels.bands
        classes = layers.labels.classes()
        is_seen = classes > 0.0
    else:
        pixels = layers.mosaic
        red, green, blue, opacity = pixels.values[:4]
        is_seen = opacity >= OPAQUE
        classes = np.where(is_seen, ground_classes(red, green, blue, rules), 0.0)
    driven = [classes == kind for kind in DRIVEN]
    blocked = classes > max(DRIVEN)
    shown = np.stack([*driven, blocked, is_seen]).astype(np.float64)
    bands = Bands(values=shown, crs=pixels.crs, transform=pixels.transform, pixel_m=pixels.pixel_m)
    # Pixels finer than cells are averaged; the nearest of coarser ones counts.
    is_fine = pixels.pixel_m < grid.cell_m
    found = bands.on(grid, Resampling.average if is_fine else Resampling.nearest)
    return np.nan_to_num(found)


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


def _slope(
    terrain: Terrain | None, grid: RouteGrid, vehicle: GroundVehicle
) -> tuple[FloatArray, BoolArray]:
    """Return the slope of each cell, radians, NaN where unknown, and whether a step is there."""
    if terrain is None:
        return np.zeros(grid.shape), np.zeros(grid.shape, np.bool_)
    east, north = grid.places()
    places = grid.positions_of(np.column_stack([east.ravel(), north.ravel()]))
    heights = terrain.altitudes_m(places[:, 0], places[:, 1]).reshape(grid.shape)
    north_slope, east_slope = np.gradient(heights, grid.cell_m)
    slope = np.arctan(np.hypot(north_slope, east_slope))
    climb = math.tan(math.radians(vehicle.largest_slope_deg)) * grid.cell_m
    limit = max(vehicle.largest_step_m, climb)
    is_step = np.zeros(grid.shape, np.bool_)
    for axis in (0, 1):
        edge = np.abs(np.diff(heights, axis=axis)) > limit
        first, second = [(0, 0), (0, 0)], [(0, 0), (0, 0)]
        first[axis], second[axis] = (0, 1), (1, 0)
        is_step |= np.pad(edge, first) | np.pad(edge, second)
    return slope, is_step


def _is_near(is_blocked: BoolArray, cell_m: float, reach_m: float) -> BoolArray:
    """Return which cells are within `reach_m` of a blocked cell or of the edge of the grid."""
    around = np.pad(is_blocked, 1, constant_values=True)
    # From middle to middle; the blocked thing begins half a cell before.
    distance = distance_transform_edt(~around)[1:-1, 1:-1] * cell_m - 0.5 * cell_m
    return np.asarray(distance < reach_m)


def _slowness(
    driven: FloatArray, slope: FloatArray, vehicle: GroundVehicle, rules: GroundRules
) -> FloatArray:
    """Return seconds a metre by the commonest class of each cell and its slope."""
    speeds = np.array([vehicle.road_mps, vehicle.grass_mps, vehicle.rough_mps])
    speed = np.where(driven.max(axis=0) > 0.0, speeds[driven.argmax(axis=0)], 0.0)
    steepest = max(math.radians(vehicle.largest_slope_deg), 1e-9)
    share = 1.0 - (1.0 - rules.slowest_on_slope) * np.clip(slope / steepest, 0.0, 1.0)
    with np.errstate(divide='ignore'):
        return np.asarray(1.0 / (speed * share))
