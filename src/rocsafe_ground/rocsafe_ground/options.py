# SPDX-License-Identifier: Apache-2.0
"""Options of the router node."""

from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.limits import require_between
from rocsafe_geo.option import option
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.ground_map import DOSES, SOURCES, MapFiles

_KNOWN = GroundVehicle()


def _known(name: str, doc: str, low: float, high: float) -> float:
    """Return the field of an option whose default is that of a vehicle."""
    found: float = option(getattr(_KNOWN, name), doc, low, high)
    return found


@dataclass(frozen=True, slots=True, kw_only=True)
class RouterOptions:
    """The vehicle and the map; one ROS parameter a field."""

    width_m: float = _known('width_m', 'width of the vehicle, m', 0.1, 10.0)
    margin_m: float = _known('margin_m', 'distance from obstacles, m', 0.0, 10.0)
    road_mps: float = _known('road_mps', 'speed on hard ground, m/s', 0.01, 30.0)
    grass_mps: float = _known('grass_mps', 'speed on grass, m/s', 0.01, 30.0)
    rough_mps: float = _known('rough_mps', 'speed on bare soil, m/s', 0.01, 30.0)
    largest_slope_deg: float = _known('largest_slope_deg', 'largest slope, degrees', 0.0, 60.0)
    largest_step_m: float = _known('largest_step_m', 'highest step, m', 0.0, 5.0)
    cell_m: float = option(0.5, 'side of a cell of the route, m', 0.05, 100.0)
    terrain_file: str = option('', 'GeoTIFF of heights; empty: the ground is level')
    labels_file: str = option(
        '', 'GeoTIFF of classes of ground and things, names in the .json beside it; empty: colours'
    )
    keep_out_files: tuple[str, ...] = option(
        (), 'files of zones not to be entered, for example [zones.kml]'
    )
    products_directory: str = option('', 'folder of the map for a request that names none')
    hazard_directory: str = option(
        '', 'folder of dose_map.tif, sources.json and plume.tif; empty: that of the map'
    )
    export_directory: str = option('', 'folder for route.json and its like; empty: none')

    def __post_init__(self) -> None:
        require_between('cell_m', self.cell_m, 0.05, 100.0, 'm')
        self.vehicle(_KNOWN.endurance_s)

    def vehicle(self, endurance_s: float) -> GroundVehicle:
        """Return the vehicle with a battery that lasts for `endurance_s`."""
        return GroundVehicle(
            width_m=self.width_m,
            margin_m=self.margin_m,
            road_mps=self.road_mps,
            grass_mps=self.grass_mps,
            rough_mps=self.rough_mps,
            largest_slope_deg=self.largest_slope_deg,
            largest_step_m=self.largest_step_m,
            endurance_s=endurance_s,
        )

    def files(self, folder: str) -> MapFiles:
        """Return the files of a map."""
        hazard = Path(self.hazard_directory) if self.hazard_directory else None
        return MapFiles(
            folder=Path(folder or self.products_directory),
            dose_map=hazard and hazard / DOSES,
            sources=hazard and hazard / SOURCES,
            gas=hazard,
            labels=Path(self.labels_file) if self.labels_file else None,
            terrain=Path(self.terrain_file) if self.terrain_file else None,
            keep_outs=tuple(Path(name) for name in self.keep_out_files),
        )
