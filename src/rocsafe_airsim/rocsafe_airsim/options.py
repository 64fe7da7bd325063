# SPDX-License-Identifier: Apache-2.0
"""Options of the node."""

from dataclasses import dataclass, field

from rocsafe_airsim.protocol.server import PORT
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.limits import require_count
from rocsafe_geo.position import GeoPosition


@dataclass(frozen=True, slots=True, kw_only=True)
class AirsimOptions:
    """ROS parameters of the node: its address, and the origin of the mission's frame."""

    host: str = field(
        default='127.0.0.1',
        metadata={'doc': 'address to listen on; whoever reaches it commands the vehicles'},
    )
    port: int = field(default=PORT, metadata={'doc': 'TCP port; 0: any', 'min': 0, 'max': 65_535})
    vehicles: tuple[str, ...] = field(
        default=(),
        metadata={'doc': 'the port is opened when these are heard; empty: at once'},
    )
    origin_latitude_deg: float = field(
        default=0.0, metadata={'doc': 'latitude of the origin, deg', 'min': -90.0, 'max': 90.0}
    )
    origin_longitude_deg: float = field(
        default=0.0, metadata={'doc': 'longitude of the origin, deg', 'min': -180.0, 'max': 180.0}
    )
    origin_altitude_m: float = field(
        default=0.0, metadata={'doc': 'its altitude, m', 'min': -1e3, 'max': 1e4}
    )

    def __post_init__(self) -> None:
        require_count('port', self.port, 0, 65_535)
        if not self.host:
            raise ValueError('host is empty: must be an address of this machine')

    def frame(self) -> LocalFrame:
        """Return the frame of the mission."""
        place = (self.origin_latitude_deg, self.origin_longitude_deg, self.origin_altitude_m)
        return LocalFrame(GeoPosition(*place))
