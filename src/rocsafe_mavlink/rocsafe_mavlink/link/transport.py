# SPDX-License-Identifier: Apache-2.0
"""Bytes in and out, without waiting: UDP, TCP and serial ports.

A connection that breaks is opened again at a later call; what was to be sent meanwhile is lost, as
on a radio. Nothing here knows MAVLink.
"""

import contextlib
import os
import socket
from collections.abc import Callable
from typing import Protocol

from rocsafe_geo.storage.serial_line import is_baud, open_serial
from rocsafe_mavlink.errors import EndpointError
from rocsafe_mavlink.link.endpoint import Endpoint, EndpointKind
from rocsafe_mavlink.link.link import Address
from rocsafe_mavlink.link.link_limits import LINK_LIMITS

Piece = tuple[Address, bytes]


class Transport(Protocol):
    """Carries bytes for a station."""

    def take(self, now_s: float) -> list[Piece]:
        """Return what has come since the last call: sender and bytes."""

    def discard(self, now_s: float) -> None:
        """Throw away what has come since the last call."""

    def send(self, address: Address, data: bytes) -> bool:
        """Send to a peer; return whether it went out."""

    def close(self) -> None:
        """Close the socket or device."""


class UdpTransport:
    """Datagrams at one local port, or to and from one vehicle.

    Raises
    ------
    EndpointError
        If the port cannot be opened.
    """

    def __init__(self, endpoint: Endpoint) -> None:
        self._socket = socket.socket(_family(endpoint.host), socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        place = (endpoint.host, endpoint.port)
        try:
            if endpoint.kind is EndpointKind.UDP:
                self._socket.bind(place)
            else:
                self._socket.connect(place)
        except OSError as error:
            self._socket.close()
            raise EndpointError(f'udp {place[0]}:{place[1]}: {error.strerror}') from error
        self._is_connected = endpoint.kind is EndpointKind.UDP_OUT

    @property
    def port(self) -> int:
        """Local port."""
        return int(self._socket.getsockname()[1])

    def take(self, now_s: float) -> list[Piece]:  # noqa: ARG002 - nothing to open again
        """Return the datagrams that have arrived."""
        pieces: list[Piece] = []
        for _ in range(LINK_LIMITS.pieces):
            try:
                data, sender = self._socket.recvfrom(LINK_LIMITS.piece_bytes)
            except BlockingIOError:
                break
            except OSError:
                # An earlier datagram was refused: nobody listens at the other end yet.
                continue
            pieces.append((sender[:2], data))
        return pieces

    def discard(self, now_s: float) -> None:
        """Throw away the datagrams that have arrived, as many as a buffer holds."""
        for _ in range(LINK_LIMITS.discards):
            if len(self.take(now_s)) < LINK_LIMITS.pieces:
                break

    def send(self, address: Address, data: bytes) -> bool:
        """Send one datagram; return False if the system did not take it."""
        try:
            if self._is_connected:
                self._socket.send(data)
            else:
                self._socket.sendto(data, address)  # type: ignore[call-overload]
        except OSError:
            return False
        return True

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class StreamTransport:
    """Bytes of one connection, opened again when it breaks.

    Parameters
    ----------
    address
        Name under which its bytes are reported.
    open_stream
        Opens it and returns a descriptor that does not block; raises OSError if it cannot.
    """

    def __init__(self, address: Address, open_stream: Callable[[], int]) -> None:
        self._address = address
        self._open_stream = open_stream
        self._descriptor: int | None = None
        self._retry_at_s = -LINK_LIMITS.retry_s

    @property
    def is_open(self) -> bool:
        """Whether the connection is open."""
        return self._descriptor is not None

    def take(self, now_s: float) -> list[Piece]:
        """Return the bytes that have arrived; open the connection if it is not open."""
        self._ensure_open(now_s)
        pieces: list[Piece] = []
        while self._descriptor is not None and len(pieces) < LINK_LIMITS.pieces:
            try:
                data = os.read(self._descriptor, LINK_LIMITS.piece_bytes)
            except BlockingIOError:
                break
            except OSError:
                data = b''
            if not data:
                self.close()
                break
            pieces.append((self._address, data))
        return pieces

    def discard(self, now_s: float) -> None:
        """Throw away the bytes that have arrived, as many as the system holds."""
        for _ in range(LINK_LIMITS.discards):
            if not self.take(now_s):
                break

    def send(self, address: Address, data: bytes) -> bool:  # noqa: ARG002 - a stream has one end
        """Send bytes; return False if the connection is closed or full."""
        if self._descriptor is None:
            return False
        try:
            # A frame that is cut in two is counted as damaged by its reader.
            return os.write(self._descriptor, data) == len(data)
        except BlockingIOError:
            return False
        except OSError:
            self.close()
            return False

    def close(self) -> None:
        """Close the connection; the next `take` opens it again."""
        if self._descriptor is not None:
            with contextlib.suppress(OSError):
                os.close(self._descriptor)
        self._descriptor = None

    def _ensure_open(self, now_s: float) -> None:
        if self._descriptor is None and now_s >= self._retry_at_s:
            self._retry_at_s = now_s + LINK_LIMITS.retry_s
            with contextlib.suppress(OSError):
                self._descriptor = self._open_stream()


def open_transport(endpoint: Endpoint) -> Transport:
    """Return the transport of `endpoint`.

    Raises
    ------
    EndpointError
        If a port cannot be opened, or the system does not know the baud rate.
    """
    if endpoint.kind in (EndpointKind.UDP, EndpointKind.UDP_OUT):
        return UdpTransport(endpoint)
    if endpoint.kind is EndpointKind.TCP:
        return StreamTransport(address_of(endpoint), lambda: _open_tcp(endpoint))
    if not is_baud(endpoint.baud):
        raise EndpointError(f'{endpoint.device}: the system has no baud rate {endpoint.baud}')
    return StreamTransport(
        endpoint.device, lambda: open_serial(endpoint.device, endpoint.baud, os.O_RDWR)
    )


def address_of(endpoint: Endpoint) -> Address:
    """Return the address under which the other end of a calling `endpoint` is heard."""
    if endpoint.kind is EndpointKind.SERIAL:
        return endpoint.device
    return endpoint.host, endpoint.port


def _open_tcp(endpoint: Endpoint) -> int:
    connection = socket.socket(_family(endpoint.host), socket.SOCK_STREAM)
    connection.setblocking(False)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    try:
        connection.connect((endpoint.host, endpoint.port))
    except BlockingIOError:
        # The connection is being made; until then reading finds nothing.
        pass
    except OSError:
        connection.close()
        raise
    return connection.detach()


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ':' in host else socket.AF_INET
