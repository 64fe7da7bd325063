# SPDX-License-Identifier: Apache-2.0
"""All that a route is planned on, from the folder of a run or of a map."""

import math
from collections.abc import Hashable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rocsafe_geo.arrays import BoolArray
from rocsafe_geo.limits import require_between
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.regions.area_files import areas_of_kind, read_areas
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_ground.dose.dose_field import DoseField, dose_field, origin_of
from rocsafe_ground.dose.source_posterior import SourcePosterior, read_sources
from rocsafe_ground.dose.toxic_load import GasField, read_gas
from rocsafe_ground.drivable.drivable_ground import DrivableGround, Layers, Reason, drivable_ground
from rocsafe_ground.drivable.labels import read_labels
from rocsafe_ground.drivable.raster import Bands, read_bands
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.errors import NoMapError

MOSAIC, HEIGHTS, DOSES, SOURCES = 'mosaic.tif', 'map/error.tif', 'dose_map.tif', 'sources.json'
RELEASES, PLAN = 'release.json', 'plan.geojson'
EXCLUSION = 'exclusion'
HEIGHT_BAND, AGE_BAND = 1, 2
DOSE_BANDS = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class MapFiles:
    """Files of the products of a survey.

    Attributes
    ----------
    folder
        Of a run, or with a mosaic.
    dose_map, sources
        Files; None: those of the folder.
    gas
        Folder of plume and threat zones; None: the same folder.
    labels
        GeoTIFF of labelled ground; None: colours tell what the ground is.
    terrain
        Elevation model; None: the ground is taken for level.
    keep_outs
        Files of zones not to be entered.
    """

    folder: Path
    dose_map: Path | None = None
    sources: Path | None = None
    gas: Path | None = None
    labels: Path | None = None
    terrain: Path | None = None
    keep_outs: tuple[Path, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroundMap:
    """Ground and dose rates on one grid.

    Attributes
    ----------
    grid
        Its cells.
    ground
        Where the vehicle can drive, dose rates aside.
    field
        Dose rates.
    turn_back_usvh
        No cell whose upper dose rate reaches it is free.
    gas
        Concentrations of a gas; None: none was found.
    turn_back_ppm
        No cell whose upper concentration reaches it is free.
    """

    grid: RouteGrid
    ground: DrivableGround
    field: DoseField
    turn_back_usvh: float
    gas: GasField | None = None
    turn_back_ppm: float = math.inf

    @property
    def reasons(self) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
        """Why each cell is not free, dose rates included."""
        found = self.ground.reasons.copy()
        upper = self.field.upper_usvh
        is_free = found == Reason.FREE
        found[is_free & (upper >= self.turn_back_usvh)] = Reason.HOT
        found[is_free & np.isnan(upper)] = Reason.UNKNOWN
        if self.gas is not None:
            is_gassed = self.gas.upper_ppm >= self.turn_back_ppm
            found[(found == Reason.FREE) & is_gassed] = Reason.GASSED
        return found

    def blocked_at(self, places: Iterable[GeoPosition], radius_m: float) -> 'GroundMap':
        """Return the map with obstacles at places, which nothing may come nearer than a radius."""
        reasons = self.ground.reasons.ravel().copy()
        for place in places:
            near, distances = self.grid.cells_within(*self.grid.enu_of(place), radius_m)
            reasons[near[reasons[near] == Reason.FREE]] = Reason.TOO_NEAR
            reasons[near[distances < 0.5 * self.grid.cell_m]] = Reason.OBSTACLE
        shaped = reasons.reshape(self.grid.shape)
        return replace(self, ground=replace(self.ground, reasons=shaped))

    @property
    def is_free(self) -> BoolArray:
        """Whether a cell may be entered."""
        return np.asarray(self.reasons == Reason.FREE)


def read_posterior(files: MapFiles) -> SourcePosterior | None:
    """Return the sources that belong to a map; None if its folder has none."""
    path = files.sources or files.folder / SOURCES
    return read_sources(path) if files.sources or path.is_file() else None


def read_ground_map(
    files: MapFiles,
    vehicle: GroundVehicle,
    cell_m: float,
    turn_back_usvh: float,
    turn_back_ppm: float = math.inf,
) -> GroundMap:
    """Return the map that files make; see `MapReader.read`."""
    return MapReader().read(files, vehicle, cell_m, turn_back_usvh, turn_back_ppm)


class MapReader:
    """Reads maps; of one that has only other dose rates than the last it keeps the ground."""

    def __init__(self) -> None:
        self._known: tuple[Hashable, RouteGrid, DrivableGround] | None = None

    def read(
        self,
        files: MapFiles,
        vehicle: GroundVehicle,
        cell_m: float,
        turn_back_usvh: float,
        turn_back_ppm: float = math.inf,
    ) -> GroundMap:
        """Return the map that files make.

        Raises
        ------
        NoMapError
            If the mosaic or the dose map is missing or not georeferenced, or they do not overlap.
        ValueError
            If an option is out of range, or another file cannot be read.
        """
        require_between('cell_m', cell_m, 0.05, 100.0, 'm')
        require_between('turn_back_usvh', turn_back_usvh, 1e-3, 1e9, 'uSv/h')
        if not files.folder.is_dir():
            raise NoMapError(f'{files.folder}: no such folder')
        doses_path = files.dose_map or files.folder / DOSES
        doses = read_bands(doses_path)
        if len(doses.values) < DOSE_BANDS:
            raise NoMapError(
                f'{doses_path}: has {len(doses.values)} bands: must have mean, deviation, upper '
                '95 %'
            )
        if (
            not (np.isfinite(doses.values) | np.isnan(doses.values)).all()
            or (doses.values < 0).any()
        ):
            raise NoMapError(f'{doses_path}: has a dose rate below 0, or an infinite one')
        grid, ground = self._ground(files, vehicle, cell_m, origin_of(doses))
        field = dose_field(doses, read_posterior(files), grid)
        if np.isnan(field.mean_usvh).all():
            raise NoMapError(f'{doses_path}: does not overlap {files.folder / MOSAIC}')
        return GroundMap(
            grid=grid,
            ground=ground,
            field=field,
            turn_back_usvh=turn_back_usvh,
            gas=read_gas(files.gas or files.folder, grid),
            turn_back_ppm=turn_back_ppm,
        )

    def _ground(
        self, files: MapFiles, vehicle: GroundVehicle, cell_m: float, origin: GeoPosition | None
    ) -> tuple[RouteGrid, DrivableGround]:
        key = _stamps(files), vehicle, cell_m, origin
        if self._known is None or self._known[0] != key:
            self._known = key, *_read_ground(files, vehicle, cell_m, origin)
        return self._known[1:]


def _stamps(files: MapFiles) -> tuple[tuple[Path, int, int], ...]:
    """Return path, size and time of the files of the ground that are there."""
    names = [files.folder / name for name in (MOSAIC, HEIGHTS, PLAN)]
    names += [path for path in (files.labels, files.terrain, *files.keep_outs) if path]
    stats = [(path, path.stat()) for path in names if path.is_file()]
    return tuple((path, stat.st_size, stat.st_mtime_ns) for path, stat in stats)


def _read_ground(
    files: MapFiles, vehicle: GroundVehicle, cell_m: float, origin: GeoPosition | None
) -> tuple[RouteGrid, DrivableGround]:
    mosaic = read_bands(files.folder / MOSAIC)
    if len(mosaic.values) < 4:
        raise NoMapError(
            f'{files.folder / MOSAIC}: has {len(mosaic.values)} bands: must have red, green, '
            'blue and opacity'
        )
    grid = _grid(mosaic, origin, cell_m)
    path = files.folder / HEIGHTS
    standing = read_bands(path) if path.is_file() else None
    layers = Layers(
        mosaic=mosaic,
        labels=read_labels(files.labels) if files.labels else None,
        heights=_band(standing, HEIGHT_BAND),
        ages=_band(standing, AGE_BAND),
        terrain=read_terrain(files.terrain) if files.terrain else None,
        keep_outs=[area.polygon(grid.frame) for area in _keep_outs(files)],
    )
    return grid, drivable_ground(layers, grid, vehicle)


def _keep_outs(files: MapFiles) -> Iterator[SurveyArea]:
    """Yield the zones of an operator, and the exclusions of the plan of a run."""
    for path in files.keep_outs:
        yield from read_areas(path)
    plan = files.folder / PLAN
    if plan.is_file():
        yield from areas_of_kind(plan, EXCLUSION)


def _band(bands: Bands | None, number: int) -> Bands | None:
    """Return one band; None if it is not there."""
    if bands is None or len(bands.values) <= number:
        return None
    return replace(bands, values=bands.values[number : number + 1])


def _grid(mosaic: Bands, origin: GeoPosition | None, cell_m: float) -> RouteGrid:
    """Return the grid over a mosaic, about the origin of the dose map if it has one."""
    if origin is None:
        west, south, east, north = mosaic.bounds_in('EPSG:4326')
        origin = GeoPosition(0.5 * (south + north), 0.5 * (west + east), 0.0)
    probe = RouteGrid(origin=origin, west_m=0.0, south_m=0.0, cell_m=cell_m, rows=2, columns=2)
    west, south, east, north = mosaic.bounds_in(probe.projection)
    return RouteGrid(
        origin=origin,
        west_m=west,
        south_m=south,
        cell_m=cell_m,
        rows=max(2, math.ceil((north - south) / cell_m)),
        columns=max(2, math.ceil((east - west) / cell_m)),
    )
