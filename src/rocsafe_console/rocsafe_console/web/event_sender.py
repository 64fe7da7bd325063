# SPDX-License-Identifier: Apache-2.0
"""Sends Cursor on Target events once a second: by datagrams, or to a TAK server by TLS."""

import asyncio
import contextlib
import socket
from collections.abc import Callable

from rocsafe_console.outward.cursor_on_target import PERIOD_S, events_of
from rocsafe_console.outward.event_target import EventTarget
from rocsafe_console.web.context import Context

MULTICAST_HOPS = 1
CONNECT_S = 10.0
SEND_S = 5.0
AGAIN_S, MOST_AGAIN_S = 1.0, 30.0
READ_BYTES = 65536
Say = Callable[[str], None]


class _Teller:
    """Tells a fault once, until another one or none comes."""

    def __init__(self, target: EventTarget, say: Say) -> None:
        self._target, self._say, self._told = target, say, ''

    def tell(self, text: str) -> None:
        if text and text != self._told:
            self._say(f'Cursor on Target to {self._target}: {text}')
        self._told = text


async def send_events(context: Context, say: Say) -> None:
    """Send events until cancelled; a fault is told once."""
    target = context.options.cursor_on_target
    if target is None:
        return
    teller = _Teller(target, say)
    if target.identity is None:
        await _send_datagrams(context, target, teller)
    else:
        await _send_streams(context, target, teller)


async def _send_datagrams(context: Context, target: EventTarget, teller: _Teller) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setblocking(False)
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, MULTICAST_HOPS)
        while True:
            await asyncio.sleep(PERIOD_S)
            try:
                for event in _events(context):
                    sender.sendto(event, (target.host, target.port))
                teller.tell('')
            except OSError as error:
                teller.tell(str(error))


async def _send_streams(context: Context, target: EventTarget, teller: _Teller) -> None:
    """Keep a connection to the server; after a fault, try again later and later."""
    again_s = AGAIN_S
    while True:
        try:
            connecting = asyncio.open_connection(
                target.host, target.port, ssl=target.tls(),
                server_hostname=target.name or target.host,
            )  # fmt: skip
            reader, writer = await asyncio.wait_for(connecting, CONNECT_S)
        except (OSError, asyncio.TimeoutError) as error:
            teller.tell(str(error) or f'no connection within {CONNECT_S:g} s')
        else:
            try:
                await _send_stream(context, reader, writer, teller)
            except (OSError, asyncio.TimeoutError) as error:
                teller.tell(str(error) or f'it did not read within {SEND_S:g} s')
            finally:
                writer.transport.abort()
            again_s = AGAIN_S
        await asyncio.sleep(again_s)
        again_s = min(2.0 * again_s, MOST_AGAIN_S)


async def _send_stream(
    context: Context,
    reader: asyncio.StreamReader,
    writer: asyncio.StreamWriter,
    teller: _Teller,
) -> None:
    """Send events to a server; ends with `OSError` when it goes."""
    heard = asyncio.create_task(_discard(reader))
    try:
        while not (await asyncio.wait((heard,), timeout=PERIOD_S))[0]:
            writer.write(b''.join(event + b'\n' for event in _events(context)))
            await asyncio.wait_for(writer.drain(), SEND_S)
            teller.tell('')
        heard.result()
        raise ConnectionError('the server has closed the connection')
    finally:
        heard.cancel()
        with contextlib.suppress(asyncio.CancelledError, OSError):
            await heard


async def _discard(reader: asyncio.StreamReader) -> None:
    """Read what the server sends of others, which nobody here wants, until its end."""
    while await reader.read(READ_BYTES):
        pass


def _events(context: Context) -> list[bytes]:
    now_s = context.clock()
    with context.live.lock:
        events = events_of(context.live.picture, now_s)
    return [event.to_xml(now_s) for event in events]
