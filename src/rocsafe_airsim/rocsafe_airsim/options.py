# SPDX-License-Identifier: Apache-2.0
"""Options of the node."""

from dataclasses import dataclass

from rocsafe_airsim.protocol.server import PORT
from rocsafe_geo.limits import require_count
from rocsafe_geo.option import option
from rocsafe_geo.origin_options import OriginOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class AirsimOptions(OriginOptions):
    """ROS parameters of the node: its address, and the origin of the mission's frame."""

    host: str = option(
        '127.0.0.1', 'address to listen on; whoever reaches it commands the vehicles'
    )
    port: int = option(PORT, 'TCP port; 0: any', 0, 65_535)
    vehicles: tuple[str, ...] = option(
        (), 'the port is opened when these are heard; empty: at once'
    )

    def __post_init__(self) -> None:
        require_count('port', self.port, 0, 65_535)
        if not self.host:
            raise ValueError('host is empty: must be an address of this machine')
