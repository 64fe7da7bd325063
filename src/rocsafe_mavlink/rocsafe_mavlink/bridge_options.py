# SPDX-License-Identifier: Apache-2.0
"""Options of the bridge that are the same for all of its drones."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from rocsafe_geo.origin_options import OriginOptions
from rocsafe_mavlink.drone.drone import DroneSpec
from rocsafe_mavlink.drone_options import ON_WIND, DroneOptions
from rocsafe_mavlink.link.link import LinkIdentity
from rocsafe_mavlink.plan.flight_limits import FlightLimits

_MOVED = {
    'highest_m': 'max_height_agl_m',
    'vehicles': 'a list, drones, in the file that drones_file names',
    'allow_network': 'allow_lan of a drone in the file that drones_file names',
    **{
        old: f'{new} of a drone in the file that drones_file names'
        for old, new in {
            'links': 'link',
            'systems': 'system',
            'components': 'component',
            'speeds_mps': 'speed_mps',
            'hovers_s': 'hover_s',
            'endurances_s': 'endurance_s',
            'image_folders': 'image_folder',
            'signing_key_files': 'signing_key_file',
            'geoid_separations_m': 'geoid_separation_m',
        }.items()
    },
}


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeOptions(OriginOptions):
    """Parameters of the bridge."""

    MOVED_PARAMETERS: ClassVar[Mapping[str, str]] = _MOVED

    drones_file: str = field(
        default='',
        metadata={'doc': 'YAML file of the drones: name, link and more, see docs/real-drones.md'},
    )
    source_system: int = field(
        default=255, metadata={'doc': 'our own MAVLink system', 'min': 1, 'max': 255}
    )
    source_component: int = field(
        default=190, metadata={'doc': 'our own MAVLink component', 'min': 1, 'max': 255}
    )
    position_rate_hz: float = field(
        default=5.0, metadata={'doc': 'positions a second', 'min': 0.2, 'max': 50.0}
    )
    needs_supervisor: bool = field(
        default=False,
        metadata={'doc': 'send heartbeats only while mission/state is being published'},
    )
    state_directory: str = field(
        default='',
        metadata={'doc': 'keeps plans and photographs over restarts; empty: nothing'},
    )
    lowest_m: float = field(
        default=5.0, metadata={'doc': 'least height of a waypoint above home, metres', 'min': 0.5}
    )
    max_height_agl_m: float = field(
        default=120.0,
        metadata={
            'doc': 'greatest height above the ground, metres: 120 is the EU open category',
            'min': 1.0,
        },
    )
    furthest_m: float = field(
        default=2000.0, metadata={'doc': 'greatest distance of a waypoint from home, metres'}
    )
    smallest_charge: float = field(
        default=0.5,
        metadata={'doc': 'charge that a flight needs at its start', 'min': 0.0, 'max': 1.0},
    )
    must_return_on_link_loss: bool = field(
        default=False,
        metadata={'doc': 'refuse vehicles that do not come back when they hear nobody'},
    )
    takes_photographs: bool = field(
        default=True, metadata={'doc': 'trigger the camera at each viewpoint'}
    )
    trigger_distance_m: float = field(
        default=0.0,
        metadata={
            'doc': 'trigger the camera every so many metres of a lane instead; 0: no',
            'min': 0.0,
        },
    )
    camera_horizontal_fov_deg: float = field(
        default=60.0,
        metadata={'doc': 'angle across the image width, degrees', 'min': 5.0, 'max': 150.0},
    )

    @property
    def identity(self) -> LinkIdentity:
        """Our own MAVLink numbers."""
        return LinkIdentity(system=self.source_system, component=self.source_component)

    @property
    def horizontal_fov_rad(self) -> float:
        """Angle across the image width, radians."""
        return math.radians(self.camera_horizontal_fov_deg)

    def state_path(self, vehicle: str) -> Path | None:
        """Return the folder that keeps what must survive a restart; None: nothing is kept."""
        return Path(self.state_directory) / vehicle if self.state_directory else None

    def spec(self, drone: DroneOptions) -> DroneSpec:
        """Return the fixed properties of a drone."""
        return DroneSpec(
            name=drone.name,
            target=drone.target,
            frame=self.frame(),
            speed_mps=drone.speed_mps,
            hover_s=drone.hover_s,
            takes_photographs=self.takes_photographs,
            trigger_distance_m=self.trigger_distance_m,
            limits=FlightLimits(
                lowest_m=self.lowest_m,
                max_height_agl_m=self.max_height_agl_m,
                furthest_m=self.furthest_m,
                longest_s=drone.endurance_s,
                smallest_charge=self.smallest_charge,
                must_return_on_link_loss=self.must_return_on_link_loss,
                max_wind_mps=drone.max_wind_mps,
                max_gust_mps=drone.max_gust_mps,
                returns_in_wind=drone.on_wind == ON_WIND[1],
            ),
        )
