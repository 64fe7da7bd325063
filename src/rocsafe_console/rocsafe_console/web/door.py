# SPDX-License-Identifier: Apache-2.0
"""The door of the server: who may connect, so that nobody keeps others out by waiting.

A connection that has not asked yet is worth the least: where there are too many of one address, or
together, the oldest of these makes room for the newest. A page asks at once, and is let in
whatever waits beside it.
"""

import asyncio
import ipaddress
import os
import socket
import ssl
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache, partial
from typing import Any

from aiohttp import web

from rocsafe_console.errors import ConsoleError

# Limit for the head of a request, for the TLS handshake, and for the pause between two requests.
HEAD_S = 10.0
# A page needs about ten; most machines let a process open 1024 files.
MOST_CONNECTIONS, MOST_OF_ADDRESS = 400, 100
QUEUE = 100
# Bits of an IPv6 address that name a network: one machine may have all addresses within it.
NETWORK_BITS = 64
# Pause after the machine refused to open another connection.
PAUSE_S = 0.1
Peer = Any


class Door:
    """Accepts connections for a server of aiohttp whose `keepalive_timeout` is `HEAD_S`.

    Parameters
    ----------
    server
        Of the runner.
    tls
        None: not encrypted.
    """

    def __init__(self, server: web.Server, tls: ssl.SSLContext | None) -> None:
        self._server = server
        self._tls = tls
        self._greeted: dict[asyncio.Task[None], str] = {}
        # Address and transport of each connection, the oldest first.
        self._inside: dict[asyncio.BaseProtocol, tuple[str, asyncio.Transport]] = {}
        self._busy: set[asyncio.BaseProtocol] = set()

    @contextmanager
    def serving(self, protocol: asyncio.BaseProtocol) -> Iterator[None]:
        """Note that a request of a connection is being answered."""
        self._busy.add(protocol)
        try:
            yield
        finally:
            self._busy.discard(protocol)

    @contextmanager
    def waiting(self, protocol: asyncio.BaseProtocol) -> Iterator[None]:
        """Note that a request, though it is being answered, waits for its own end."""
        self._busy.discard(protocol)
        try:
            yield
        finally:
            self._busy.add(protocol)

    async def accept(self, listening: socket.socket) -> None:
        """Accept connections for ever."""
        loop = asyncio.get_running_loop()
        while True:
            try:
                connection, peer = await loop.sock_accept(listening)
            except OSError:
                await asyncio.sleep(PAUSE_S)
                continue
            address = address_of(peer)
            if self._is_room(address):
                task = loop.create_task(self._greet(connection, address))
                self._greeted[task] = address
                task.add_done_callback(lambda done: self._greeted.pop(done, None))
            else:
                connection.close()
            # The greeting begins, and many that come at once do not stop what is being answered.
            await asyncio.sleep(0)

    def close(self) -> None:
        """End what has not come in yet."""
        for task in self._greeted:
            task.cancel()

    async def _greet(self, connection: socket.socket, address: str) -> None:
        """Make a connection one of the server; with TLS, after the handshake."""
        limit_s = HEAD_S if self._tls else None
        # What fails or is called off is closed there. Errors of TLS, and of a handshake that takes
        # too long, are errors of the system.
        with suppress(OSError):
            transport, protocol = await asyncio.get_running_loop().connect_accepted_socket(
                self._server, connection, ssl=self._tls, ssl_handshake_timeout=limit_s
            )
            self._inside[protocol] = (address, transport)

    def _is_room(self, address: str) -> bool:
        """Make room for one more connection of an address; False if there is none."""
        alive = set(self._server.connections)
        self._inside = {one: what for one, what in self._inside.items() if one in alive}
        count = Counter(self._greeted.values())
        waiting: dict[str, list[Callable[[], None]]] = {}
        for protocol, (name, _) in self._inside.items():
            count[name] += 1
            if protocol not in self._busy:
                waiting.setdefault(name, []).append(partial(self._drop, protocol))
        for task, name in self._greeted.items():
            waiting.setdefault(name, []).append(partial(self._turn_away, task))
        if count[address] < MOST_OF_ADDRESS:
            if sum(count.values()) < MOST_CONNECTIONS:
                return True
            # The address with the most connections loses one.
            address = next((name for name, _ in count.most_common() if name in waiting), address)
        if address not in waiting:
            return False
        waiting[address][0]()
        return True

    def _turn_away(self, task: asyncio.Task[None]) -> None:
        task.cancel()
        del self._greeted[task]

    def _drop(self, protocol: asyncio.BaseProtocol) -> None:
        # What it has not read is not kept for it.
        self._inside.pop(protocol)[1].abort()


DOOR: web.AppKey[list[Door]] = web.AppKey('door', list)


async def listening_at(host: str, port: int) -> list[socket.socket]:
    """Return sockets that listen at all addresses of a host, at one port.

    Raises
    ------
    ConsoleError
        If one of the addresses cannot be listened at.
    """
    loop = asyncio.get_running_loop()
    sockets: list[socket.socket] = []
    try:
        found = await loop.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )
        for family, _, _, _, (name, number, *_rest) in dict.fromkeys(found):
            chosen = sockets[0].getsockname()[1] if sockets and not port else number
            one = socket.create_server((str(name), int(chosen)), family=family, backlog=QUEUE)
            one.setblocking(False)
            sockets.append(one)
    except OSError as error:
        for one in sockets:
            one.close()
        number = error.errno or 0
        reason = os.strerror(number) if number > 0 else error.strerror
        text = f'--host {host} --port {port}: cannot be listened at: {reason}'
        raise ConsoleError(text) from error
    return sockets


@lru_cache(maxsize=4096)
def _network(name: str) -> str:
    with suppress(ValueError):
        address = ipaddress.ip_address(name.partition('%')[0])
        if address.version == 6 and not address.ipv4_mapped:
            return str(ipaddress.ip_network((address, NETWORK_BITS), strict=False))
    return name


def address_of(peer: Peer) -> str:
    """Return the address whose connections are counted together, empty if it is not known."""
    return _network(str(peer[0])) if isinstance(peer, tuple) and peer else ''
