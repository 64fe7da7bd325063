# SPDX-License-Identifier: Apache-2.0
"""A scenario: region, vehicles, ground and sources of one mission."""

from typing import Annotated, Any, Literal

import yaml
from pydantic import Field

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_scenario.blocks.air import AirBlock
from rocsafe_scenario.blocks.block import Block, LatLon
from rocsafe_scenario.blocks.cameras import CameraBlock, OtherCameraBlock
from rocsafe_scenario.blocks.ground_vehicle import GroundVehicleBlock
from rocsafe_scenario.blocks.hosts import MOST_HOSTS, HostBlock
from rocsafe_scenario.blocks.mission import (
    ClockBlock,
    FleetBlock,
    OriginBlock,
    RegionBlock,
    SurveyBlock,
)
from rocsafe_scenario.blocks.radiation import RadiationBlock
from rocsafe_scenario.blocks.simulation import SimulationBlock
from rocsafe_scenario.blocks.vehicles import VehicleBlock
from rocsafe_scenario.limits import LARGEST_FLEET, LARGEST_SEED


class Scenario(Block):
    """The content of a scenario file."""

    name: Annotated[str, Field(pattern=r'^[A-Za-z0-9][A-Za-z0-9_-]*$', max_length=64)]
    description: str = ''
    seed: int = Field(default=0, ge=0, le=LARGEST_SEED)
    clock: ClockBlock = ClockBlock()
    origin: OriginBlock = OriginBlock()
    region: RegionBlock
    other_regions: tuple[RegionBlock, ...] = Field(default=(), max_length=1000)
    exclusions: tuple[RegionBlock, ...] = Field(default=(), max_length=1000)
    survey: SurveyBlock
    camera: CameraBlock = CameraBlock()
    other_cameras: tuple[OtherCameraBlock, ...] = Field(default=(), max_length=8)
    scene: str = 'none'
    simulation: SimulationBlock = SimulationBlock()
    fleet: FleetBlock = FleetBlock()
    hosts: tuple[HostBlock, ...] = Field(default=(), max_length=MOST_HOSTS)
    replan: Literal['never', 'on_loss'] = 'on_loss'
    on_operator_lost: Literal['hold_then_return', 'return', 'go_on'] = 'hold_then_return'
    vehicles: tuple[VehicleBlock, ...] = Field(min_length=1, max_length=LARGEST_FLEET)
    ground_vehicle: GroundVehicleBlock | None = None
    radiation: RadiationBlock = RadiationBlock()
    air: AirBlock = AirBlock()

    @property
    def vehicle_names(self) -> tuple[str, ...]:
        """Names of all vehicles, in the order of the file."""
        return tuple(vehicle.name for vehicle in self.vehicles)

    @property
    def driver_name(self) -> str:
        """Name of the ground vehicle, empty if there is none."""
        return self.ground_vehicle.name if self.ground_vehicle else ''

    @property
    def all_names(self) -> tuple[str, ...]:
        """Names of all vehicles, the ground vehicle last."""
        return (*self.vehicle_names, *([self.driver_name] if self.driver_name else []))

    @property
    def simulated(self) -> tuple[VehicleBlock, ...]:
        """Vehicles that are simulated."""
        return tuple(vehicle for vehicle in self.vehicles if not vehicle.link)

    @property
    def linked(self) -> tuple[VehicleBlock, ...]:
        """Real vehicles."""
        return tuple(vehicle for vehicle in self.vehicles if vehicle.link)

    @property
    def real_names(self) -> tuple[str, ...]:
        """Names of all real vehicles, the ground vehicle last."""
        driver = [self.driver_name] if self.ground_vehicle and self.ground_vehicle.link else []
        return (*(vehicle.name for vehicle in self.linked), *driver)

    @property
    def has_cameras(self) -> bool:
        """Whether any vehicle takes photographs; it may carry a detector alone."""
        if self.simulated and self.camera.backend != 'none':
            return True
        return any(vehicle.drone.image_folder for vehicle in self.linked)

    def linked_on(self, host: str) -> tuple[VehicleBlock, ...]:
        """Return the real vehicles of a host."""
        return tuple(vehicle for vehicle in self.linked if self.host_of(vehicle.name) == host)

    @property
    def with_simulated_detector(self) -> tuple[VehicleBlock, ...]:
        """Vehicles whose readings are those of the simulated field."""
        return tuple(v for v in self.vehicles if not v.link or v.drone.detector == 'simulated')

    @property
    def has_radiation(self) -> bool:
        """Whether there is anything to read: a real detector, a source or a background."""
        radiation = self.radiation
        has_own = len(self.with_simulated_detector) < len(self.vehicles)
        return has_own or bool(radiation.sources) or radiation.background.dose_rate_usvh > 0.0

    @property
    def metered_names(self) -> tuple[str, ...]:
        """Names of those vehicles, and of the ground vehicle if it is such a one."""
        drones = (vehicle.name for vehicle in self.with_simulated_detector)
        driver = self.ground_vehicle
        is_metered = driver and (not driver.link or driver.drone.detector == 'simulated')
        return (*drones, *([self.driver_name] if is_metered else []))

    @property
    def head(self) -> str:
        """Name of the host of `rocsafe run`; empty: all is on one machine."""
        return self.hosts[0].name if self.hosts else ''

    def host_of(self, vehicle: str) -> str:
        """Return the name of the host of a vehicle; empty: all is on one machine."""
        return next((h.name for h in self.hosts if vehicle in h.vehicles), self.head)

    def area(self) -> SurveyArea:
        """Return the region.

        Raises
        ------
        ValueError
            Saying what is wrong with the polygon.
        """
        return SurveyArea(
            boundary=_ring(self.region.polygon or ()),
            holes=tuple(map(_ring, self.region.holes)),
            name=self.name,
        )

    def exclusion_areas(self) -> tuple[SurveyArea, ...]:
        """Return the zones that are not flown over.

        Raises
        ------
        ValueError
            Naming the key, and saying what is wrong with its polygon.
        """
        return _areas('exclusions', self.exclusions)

    def other_areas(self) -> tuple[SurveyArea, ...]:
        """Return the regions to survey besides the first.

        Raises
        ------
        ValueError
            Naming the key, and saying what is wrong with its polygon.
        """
        return _areas('other_regions', self.other_regions)

    def origin_position(self) -> GeoPosition:
        """Return the origin of the local frame, on the ground."""
        altitude = self.origin.ground_altitude_m
        if self.origin.latitude_deg is None or self.origin.longitude_deg is None:
            centroid = self.area().centroid()
            return GeoPosition(
                latitude_deg=centroid.latitude_deg,
                longitude_deg=centroid.longitude_deg,
                altitude_m=altitude,
            )
        return GeoPosition(
            latitude_deg=self.origin.latitude_deg,
            longitude_deg=self.origin.longitude_deg,
            altitude_m=altitude,
        )

    @property
    def extra_rounds(self) -> int:
        """Largest number of flights after the survey, of any search."""
        return max(self.radiation.search.extra_rounds, self.air.search.extra_rounds)

    @property
    def engine_scene(self) -> str:
        """Path of the scene file that the game engine shows, '' if the ground is flat."""
        return self.camera.scene_file if self.camera.backend == 'engine' else ''

    def ground_position(self, place: LatLon) -> GeoPosition:
        """Return `place` on the flat ground."""
        return GeoPosition(
            latitude_deg=place[0],
            longitude_deg=place[1],
            altitude_m=self.origin.ground_altitude_m,
        )

    def to_yaml(self) -> str:
        """Return the scenario as a file that `read_scenario` reads, defaults written out."""
        content = self.model_dump(exclude_none=True)
        return yaml.safe_dump(_plain(content), sort_keys=False, default_flow_style=False)


def _areas(key: str, blocks: tuple[RegionBlock, ...]) -> tuple[SurveyArea, ...]:
    return tuple(_area(f'{key}[{index}]', block) for index, block in enumerate(blocks))


def _area(key: str, block: RegionBlock) -> SurveyArea:
    try:
        return SurveyArea(
            boundary=_ring(block.polygon or ()), holes=tuple(map(_ring, block.holes))
        )
    except ValueError as error:
        raise ValueError(f'{key}.polygon: {error}') from error


def _ring(places: tuple[LatLon, ...]) -> tuple[GeoPosition, ...]:
    return tuple(GeoPosition(latitude_deg=lat, longitude_deg=lon) for lat, lon in places)


def _plain(value: Any) -> Any:
    """Return `value` with lists for tuples, as YAML writes them."""
    if isinstance(value, dict):
        return {key: _plain(element) for key, element in value.items()}
    if isinstance(value, tuple):
        return [_plain(element) for element in value]
    return value
