# SPDX-License-Identifier: Apache-2.0
"""Options of the node."""

from dataclasses import dataclass, field

from rocsafe_airsim.protocol.server import PORT
from rocsafe_geo.limits import require_count
from rocsafe_geo.origin_options import OriginOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class AirsimOptions(OriginOptions):
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

    def __post_init__(self) -> None:
        require_count('port', self.port, 0, 65_535)
        if not self.host:
            raise ValueError('host is empty: must be an address of this machine')
