# SPDX-License-Identifier: Apache-2.0
"""Addresses of links, as people write them.

``udp://HOST:PORT`` waits there for vehicles; ``udp://HOST:PORT?peer=HOST:PORT`` hears that address
only (``peer`` may be repeated); ``udpout://HOST:PORT`` and ``tcp://HOST:PORT`` call a vehicle;
``serial:///dev/ttyACM0?baud=57600`` is a serial port.
"""

import ipaddress
from dataclasses import dataclass
from enum import Enum
from urllib.parse import SplitResult, parse_qs, urlsplit

from rocsafe_mavlink.errors import EndpointError

IpAddress = tuple[str, int]
DEFAULT_BAUD = 57_600
LARGEST_BAUD = 4_000_000


class EndpointKind(Enum):
    """Carrier of the bytes."""

    UDP = 'udp'
    UDP_OUT = 'udpout'
    TCP = 'tcp'
    SERIAL = 'serial'


@dataclass(frozen=True, slots=True, kw_only=True)
class Endpoint:
    """One end of a link.

    Attributes
    ----------
    kind
        Carrier of the bytes.
    host, port
        Where to wait or whom to call; not of a serial port.
    peers
        Addresses to hear; empty: any on this machine.
    device, baud
        Of a serial port.
    """

    kind: EndpointKind
    host: str = ''
    port: int = 0
    peers: tuple[IpAddress, ...] = ()
    device: str = ''
    baud: int = DEFAULT_BAUD

    @property
    def is_stream(self) -> bool:
        """Whether the bytes come without message borders."""
        return self.kind in (EndpointKind.TCP, EndpointKind.SERIAL)

    @property
    def is_listening(self) -> bool:
        """Whether it waits for vehicles."""
        return self.kind is EndpointKind.UDP

    @property
    def is_local(self) -> bool:
        """Whether no network is in it: a serial port, or both ends on this machine."""
        return self.kind is EndpointKind.SERIAL or is_loopback(self.host)


def is_loopback(host: str) -> bool:
    """Whether `host` is this machine."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'


def parse_endpoint(text: str) -> Endpoint:
    """Return the endpoint that `text` names; see the module.

    Raises
    ------
    EndpointError
        Naming the text and what is wrong with it.
    """
    try:
        return _parsed(text)
    except ValueError as error:
        raise EndpointError(f'link {text!r}: {error}') from error


def _parsed(text: str) -> Endpoint:
    parts = urlsplit(text)
    kinds = {kind.value: kind for kind in EndpointKind}
    if parts.scheme not in kinds:
        raise ValueError(f'must begin with one of: {", ".join(f"{name}://" for name in kinds)}')
    query = parse_qs(parts.query, keep_blank_values=True, strict_parsing=bool(parts.query))
    kind = kinds[parts.scheme]
    if kind is EndpointKind.SERIAL:
        return _serial(parts, query)
    peers = tuple(_address(peer) for peer in query.pop('peer', []))
    if peers and kind is not EndpointKind.UDP:
        raise ValueError('only udp:// has peers')
    _require_empty(query)
    if parts.path not in ('', '/'):
        raise ValueError(f'{parts.path!r} after the port is not understood')
    host, port = _address(parts.netloc)
    return Endpoint(kind=kind, host=host, port=port, peers=peers)


def _serial(parts: SplitResult, query: dict[str, list[str]]) -> Endpoint:
    bauds = query.pop('baud', [str(DEFAULT_BAUD)])
    _require_empty(query)
    if parts.netloc or not parts.path.strip('/'):
        raise ValueError('must name a device, like serial:///dev/ttyACM0?baud=57600')
    if len(bauds) != 1 or not bauds[0].isdecimal() or not 0 < int(bauds[0]) <= LARGEST_BAUD:
        raise ValueError(f'baud = {bauds[-1]!r} must be a number up to {LARGEST_BAUD}')
    return Endpoint(kind=EndpointKind.SERIAL, device=parts.path, baud=int(bauds[0]))


def _address(text: str) -> IpAddress:
    parts = urlsplit(f'//{text}')
    if not parts.hostname or parts.port is None or '@' in text:
        raise ValueError(f'{text!r} must be HOST:PORT')
    return parts.hostname, parts.port


def _require_empty(query: dict[str, list[str]]) -> None:
    if query:
        raise ValueError(f'option {min(query)!r} is not known')
