# SPDX-License-Identifier: Apache-2.0
"""Where Cursor on Target events go: as datagrams, or to a TAK server by TLS."""

import ssl
from dataclasses import dataclass
from pathlib import Path

from rocsafe_console.errors import ConsoleError

TLS = 'tls://'


@dataclass(frozen=True, slots=True, kw_only=True)
class EventTarget:
    """Receiver of events.

    Attributes
    ----------
    host, port
        Its address.
    identity
        PEM file with our certificate and its key; None: datagrams that are not encrypted.
    authority
        PEM file with the certificates that may have signed that of the server; not those of the
        machine, because TAK servers have authorities of their own.
    name
        Name in the certificate of the server; empty: its host.
    """

    host: str
    port: int
    identity: Path | None = None
    authority: Path | None = None
    name: str = ''

    def __str__(self) -> str:
        """Return its address for people."""
        return f'{TLS if self.identity else ""}{self.host}:{self.port}'

    def tls(self) -> ssl.SSLContext:
        """Return how to connect.

        Raises
        ------
        ConsoleError
            If a file is missing or is not what it must be.
        """
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        path = self.authority
        try:
            context.load_verify_locations(str(path))
            path = self.identity
            # A key that asks for a password would wait for a terminal.
            context.load_cert_chain(str(path), password=refuse_password)
        except (OSError, ValueError) as error:
            reason = getattr(error, 'reason', None) or getattr(error, 'strerror', None) or error
            raise ConsoleError(f'{path}: cannot be used for {self}: {reason}') from error
        return context


def target_of(
    address: str, identity: Path | None, authority: Path | None, name: str
) -> EventTarget:
    """Return the receiver by the arguments of the command.

    Raises
    ------
    ConsoleError
        If the address is no HOST:PORT, or TLS lacks a file or has one too many.
    """
    is_tls = address.startswith(TLS)
    host, _, port = address.removeprefix(TLS).rpartition(':')
    if not host or not port.isdecimal() or not 0 < int(port) < 65536:
        raise ConsoleError(f'--cursor-on-target {address!r}: must be HOST:PORT or {TLS}HOST:PORT')
    if is_tls != (identity is not None) or is_tls != (authority is not None):
        raise ConsoleError(
            f'--tak-identity and --tak-authority: both are needed for {TLS}, none without it'
        )
    target = EventTarget(
        host=host, port=int(port), identity=identity, authority=authority, name=name
    )
    if is_tls:
        target.tls()
    return target


def refuse_password() -> str:
    """Refuse to ask for the password of a key; raises `ValueError`."""
    raise ValueError('the key must have no password')
