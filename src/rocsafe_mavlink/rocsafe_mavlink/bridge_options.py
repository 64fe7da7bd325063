# SPDX-License-Identifier: Apache-2.0
"""Options of the bridge: lists run in parallel, one entry a vehicle; an empty list is defaults."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.drone.drone import DroneSpec
from rocsafe_mavlink.flight.preflight import FlightLimits
from rocsafe_mavlink.link.link import LinkIdentity

_LISTS = ('systems', 'components', 'speeds_mps', 'hovers_s', 'endurances_s', 'image_folders',
          'signing_key_files', 'geoid_separations_m')  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class BridgeOptions:
    """Parameters of the bridge."""

    vehicles: tuple[str, ...] = field(
        default=(), metadata={'doc': 'names of the vehicles, which are their namespaces'}
    )
    links: tuple[str, ...] = field(
        default=(),
        metadata={
            'doc': 'link of each vehicle: udp://HOST:PORT, udpout://HOST:PORT, tcp://HOST:PORT or '
            'serial:///dev/NAME?baud=N; vehicles may share one'
        },
    )
    systems: tuple[int, ...] = field(
        default=(), metadata={'doc': 'MAVLink system of each vehicle (1)', 'min': 1, 'max': 255}
    )
    components: tuple[int, ...] = field(
        default=(), metadata={'doc': 'MAVLink component of each (1)', 'min': 1, 'max': 255}
    )
    speeds_mps: tuple[float, ...] = field(
        default=(), metadata={'doc': 'speed of each over ground, m/s (5)', 'min': 0.1, 'max': 50.0}
    )
    hovers_s: tuple[float, ...] = field(
        default=(),
        metadata={'doc': 'standing time of each at a viewpoint, s (1)', 'min': 0.0, 'max': 600.0},
    )
    endurances_s: tuple[float, ...] = field(
        default=(),
        metadata={'doc': 'flight time of each on a full battery, s (1500)', 'min': 1.0},
    )
    image_folders: tuple[str, ...] = field(
        default=(),
        metadata={
            'doc': 'folder of the JPEG files of each, rtsp://..., http://... or /dev/video...; '
            'empty: none'
        },
    )
    signing_key_files: tuple[str, ...] = field(
        default=(),
        metadata={
            'doc': 'signing key of each, mode 0600; time stamps go beside it; empty: unsigned'
        },
    )
    geoid_separations_m: tuple[float, ...] = field(
        default=(),
        metadata={'doc': 'geoid above the ellipsoid where each flies, m, if it does not tell'},
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
    allow_network: bool = field(
        default=False, metadata={'doc': 'listen for vehicles beyond this machine'}
    )
    needs_supervisor: bool = field(
        default=False,
        metadata={'doc': 'send heartbeats only while mission/state is being published'},
    )
    state_directory: str = field(
        default='',
        metadata={'doc': 'keeps plans and photographs over restarts; empty: nothing'},
    )
    origin_latitude_deg: float = field(
        default=0.0, metadata={'doc': 'WGS84 latitude of the mission origin, degrees'}
    )
    origin_longitude_deg: float = field(
        default=0.0, metadata={'doc': 'WGS84 longitude of the mission origin, degrees'}
    )
    origin_altitude_m: float = field(
        default=0.0, metadata={'doc': 'altitude of the ground there above the ellipsoid, metres'}
    )
    lowest_m: float = field(
        default=5.0, metadata={'doc': 'least height of a waypoint above home, metres', 'min': 0.5}
    )
    highest_m: float = field(
        default=120.0, metadata={'doc': 'greatest height of a waypoint above home, metres'}
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

    def __post_init__(self) -> None:
        """Refuse lists that do not belong together."""
        count = len(self.vehicles)
        if len(set(self.vehicles)) != count:
            raise ValueError(f'vehicles {list(self.vehicles)} must differ from each other')
        if len(self.links) != count:
            raise ValueError(
                f'links has {len(self.links)} entries: must have {count}, as vehicles'
            )
        for name in _LISTS:
            length = len(getattr(self, name))
            if length not in (0, count):
                raise ValueError(f'{name} has {length} entries: must have {count} or none')
        places = list(zip(self.links, self.targets, strict=True))
        if len(set(places)) != count:
            raise ValueError('vehicles on one link must differ in systems or components')

    @property
    def targets(self) -> tuple[tuple[int, int], ...]:
        """(system, component) of each vehicle."""
        systems = self.systems or (1,) * len(self.vehicles)
        components = self.components or (1,) * len(self.vehicles)
        return tuple(zip(systems, components, strict=True))

    @property
    def identity(self) -> LinkIdentity:
        """Who we are on the wire."""
        return LinkIdentity(system=self.source_system, component=self.source_component)

    @property
    def frame(self) -> LocalFrame:
        """Frame of the mission."""
        return LocalFrame(
            GeoPosition(
                self.origin_latitude_deg, self.origin_longitude_deg, self.origin_altitude_m
            )
        )

    @property
    def horizontal_fov_rad(self) -> float:
        """Angle across the image width."""
        return math.radians(self.camera_horizontal_fov_deg)

    def state_path(self, vehicle: str) -> Path | None:
        """Return the folder that keeps what a vehicle must not forget; None: nowhere."""
        return Path(self.state_directory) / vehicle if self.state_directory else None

    def text_of(self, name: str, index: int) -> str:
        """Return entry `index` of a list of texts, empty if the list is."""
        values: tuple[str, ...] = getattr(self, name)
        return values[index] if values else ''

    def number_of(self, name: str, index: int, default: float) -> float:
        """Return entry `index` of a list of numbers, `default` if the list is empty."""
        values: tuple[float, ...] = getattr(self, name)
        return values[index] if values else default

    def separation_m(self, index: int) -> float:
        """Return the geoid's height above the ellipsoid; NaN if nobody gave it."""
        return self.number_of('geoid_separations_m', index, math.nan)

    def spec(self, index: int) -> DroneSpec:
        """Return what vehicle `index` is."""
        return DroneSpec(
            name=self.vehicles[index],
            target=self.targets[index],
            frame=self.frame,
            speed_mps=self.number_of('speeds_mps', index, 5.0),
            hover_s=self.number_of('hovers_s', index, 1.0),
            takes_photographs=self.takes_photographs,
            trigger_distance_m=self.trigger_distance_m,
            limits=FlightLimits(
                lowest_m=self.lowest_m,
                highest_m=self.highest_m,
                furthest_m=self.furthest_m,
                longest_s=self.number_of('endurances_s', index, 1500.0),
                smallest_charge=self.smallest_charge,
                must_return_on_link_loss=self.must_return_on_link_loss,
            ),
        )
