# SPDX-License-Identifier: Apache-2.0
"""Bytes of a detector without waiting: from a serial port, or in datagrams.

A port that cannot be opened, or breaks, is opened again after a pause that doubles; after a number
of tries in a row it is given up.
"""

import contextlib
import ipaddress
import os
import socket
from collections.abc import Callable
from typing import Protocol

from rocsafe_geo.storage.serial_line import is_baud, open_serial
from rocsafe_radiation.errors import DetectorLostError

LARGEST_PIECE = 65_535
# One call takes at most this many pieces, so that a flood cannot block its caller.
LARGEST_TAKE = 64
FIRST_PAUSE_S, LARGEST_PAUSE_S = 1.0, 30.0


class LineSource(Protocol):
    """Where the bytes of a detector come from."""

    def take(self, now_s: float) -> list[bytes]:
        """Return what has come since the last call, `now_s` by a steady clock.

        Raises
        ------
        DetectorLostError
            If it is given up.
        """

    def close(self) -> None:
        """Close the port."""


class SerialSource:
    """Bytes of a serial port.

    Parameters
    ----------
    device, baud
        The port.
    largest_tries
        Tries in a row after which it is given up.
    tell
        Called with a line when it was opened, when it broke, and at each try that failed.

    Raises
    ------
    ValueError
        If the system does not know the baud rate.
    """

    def __init__(
        self, device: str, baud: int, largest_tries: int, tell: Callable[[str], None]
    ) -> None:
        if not is_baud(baud):
            raise ValueError(f'baud is {baud}: the system has no such rate')
        self._device, self._baud = device, baud
        self._largest_tries, self._tell = largest_tries, tell
        self._descriptor: int | None = None
        self._retry_at_s = -LARGEST_PAUSE_S
        self._tries = 0

    def take(self, now_s: float) -> list[bytes]:
        """See `LineSource.take`."""
        self._ensure_open(now_s)
        pieces: list[bytes] = []
        while self._descriptor is not None and len(pieces) < LARGEST_TAKE:
            try:
                data = os.read(self._descriptor, LARGEST_PIECE)
            except BlockingIOError:
                break
            except OSError:
                data = b''
            if not data:
                self.close()
                self._tell(f'{self._device}: the connection broke')
                self._retry_at_s = now_s + FIRST_PAUSE_S
                break
            self._tries = 0
            pieces.append(data)
        return pieces

    def close(self) -> None:
        """Close the port; the next `take` opens it again."""
        if self._descriptor is not None:
            with contextlib.suppress(OSError):
                os.close(self._descriptor)
        self._descriptor = None

    def _ensure_open(self, now_s: float) -> None:
        if self._descriptor is not None or now_s < self._retry_at_s:
            return
        self._tries += 1
        try:
            self._descriptor = open_serial(self._device, self._baud, os.O_RDONLY)
            self._tell(f'{self._device}: open')
        except OSError as error:
            words = f'{self._device}: {error.strerror or error}'
            if self._tries >= self._largest_tries:
                raise DetectorLostError(f'{words}: given up after {self._tries} tries') from error
            pause_s = min(FIRST_PAUSE_S * 2.0 ** (self._tries - 1), LARGEST_PAUSE_S)
            self._retry_at_s = now_s + pause_s
            self._tell(f'{words}: try {self._tries} of {self._largest_tries}')


class DatagramSource:
    """Datagrams at a local UDP port, each with whole lines.

    Parameters
    ----------
    host, port
        Where they come in.
    allow_lan
        Whether that may be reached from other machines.

    Raises
    ------
    ValueError
        If the port cannot be opened, or listens beyond this machine without being allowed to.
    """

    def __init__(self, host: str, port: int, *, allow_lan: bool) -> None:
        if not (allow_lan or _is_loopback(host)):
            raise ValueError(
                f'udp {host}:{port} listens beyond this machine: set allow_lan: true to allow it'
            )
        family = socket.AF_INET6 if ':' in host else socket.AF_INET
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.bind((host, port))
        except OSError as error:
            self._socket.close()
            raise ValueError(f'udp {host}:{port}: {error.strerror}') from error

    @property
    def port(self) -> int:
        """Local port."""
        return int(self._socket.getsockname()[1])

    def take(self, now_s: float) -> list[bytes]:  # noqa: ARG002 - nothing to open again
        """See `LineSource.take`; a datagram ends its last line."""
        pieces: list[bytes] = []
        for _ in range(LARGEST_TAKE):
            try:
                data = self._socket.recv(LARGEST_PIECE)
            except OSError:
                break
            pieces.append(data if data.endswith(b'\n') else data + b'\n')
        return pieces

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'
