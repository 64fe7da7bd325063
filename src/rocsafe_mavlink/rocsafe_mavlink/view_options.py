# SPDX-License-Identifier: Apache-2.0
"""Options of the node ``mavlink_view``."""

from dataclasses import dataclass

from rocsafe_geo.option import option
from rocsafe_mavlink.errors import EndpointError
from rocsafe_mavlink.link.endpoint import Endpoint, EndpointKind, parse_endpoint

QGROUNDCONTROL = 'udpout://127.0.0.1:14550'


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewOptions:
    """Options of the view."""

    endpoint: str = option(QGROUNDCONTROL, 'where a ground station listens: udpout://HOST:PORT')

    def __post_init__(self) -> None:
        _ = self.address

    @property
    def address(self) -> Endpoint:
        """Address at which the station listens.

        Raises
        ------
        ValueError
            If it is no address to send datagrams to.
        """
        try:
            endpoint = parse_endpoint(self.endpoint)
        except EndpointError as error:
            raise ValueError(f'endpoint: {error}') from error
        if endpoint.kind is not EndpointKind.UDP_OUT:
            raise ValueError(f'endpoint = {self.endpoint!r}: must be udpout://HOST:PORT')
        return endpoint
