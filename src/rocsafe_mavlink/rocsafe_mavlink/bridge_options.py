# SPDX-License-Identifier: Apache-2.0
"""Options of the bridge that are the same for all of its drones."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rocsafe_geo.option import option
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

    drones_file: str = option(
        '', 'YAML file of the drones: name, link and more, see docs/real-drones.md'
    )
    source_system: int = option(255, 'our own MAVLink system', 1, 255)
    source_component: int = option(190, 'our own MAVLink component', 1, 255)
    position_rate_hz: float = option(5.0, 'positions a second', 0.2, 50.0)
    needs_supervisor: bool = option(
        False, 'send heartbeats only while mission/state is being published'
    )
    state_directory: str = option('', 'keeps plans and photographs over restarts; empty: nothing')
    lowest_m: float = option(5.0, 'least height of a waypoint above home, metres', 0.5)
    max_height_agl_m: float = option(
        120.0, 'greatest height above the ground, metres: 120 is the EU open category', 1.0
    )
    separation_m: float = option(
        0.0, 'a take-off waits while another vehicle is nearer than so many metres; 0: no', 0.0
    )
    furthest_m: float = option(2000.0, 'greatest distance of a waypoint from home, metres')
    smallest_charge: float = option(0.5, 'charge that a flight needs at its start', 0.0, 1.0)
    must_return_on_link_loss: bool = option(
        False, 'refuse vehicles that do not come back when they hear nobody'
    )
    takes_photographs: bool = option(True, 'trigger the camera at each viewpoint')
    trigger_distance_m: float = option(
        0.0, 'trigger the camera every so many metres of a lane instead; 0: no', 0.0
    )
    camera_horizontal_fov_deg: float = option(
        60.0, 'angle across the image width, degrees', 5.0, 150.0
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
                separation_m=self.separation_m,
                furthest_m=self.furthest_m,
                longest_s=drone.endurance_s,
                smallest_charge=self.smallest_charge,
                must_return_on_link_loss=self.must_return_on_link_loss,
                max_wind_mps=drone.max_wind_mps,
                max_gust_mps=drone.max_gust_mps,
                returns_in_wind=drone.on_wind == ON_WIND[1],
            ),
        )
