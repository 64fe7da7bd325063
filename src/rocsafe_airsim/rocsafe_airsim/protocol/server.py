# SPDX-License-Identifier: Apache-2.0
"""The TCP server: connections, calls that run side by side, one answer each."""

import asyncio
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any

from rocsafe_airsim.errors import AirsimError, ProtocolError
from rocsafe_airsim.protocol.wire import Call, CallReader, answer, refusal

PORT = 41451
MOST_CLIENTS = 64
# Calls of one client that wait for their end, such as movements; no more are read meanwhile.
MOST_PENDING = 64
# A client that reads nothing, or makes no call at all, for so long has gone, or is stuck.
READ_S = 30.0
CHUNK = 65_536
# So many different refusals are told, each once and cut to a length.
MOST_TOLD, LONGEST_TOLD = 200, 300
Handle = Callable[[Call], Awaitable[Any]]
Tell = Callable[[str], None]


class AirsimServer:
    """Serves calls on one port; every call has one answer, or its connection is closed.

    Parameters
    ----------
    handle
        Carries a call out; raises `AirsimError` to refuse it.
    tell
        Takes a line for people.
    """

    def __init__(self, handle: Handle, tell: Tell) -> None:
        self._handle, self._tell = handle, tell
        self._refusals: set[str] = set()
        self._server: asyncio.Server | None = None
        self._serving: set[asyncio.Task[None]] = set()

    @property
    def clients(self) -> int:
        """Connections that are open."""
        return len(self._serving)

    async def start(self, host: str, port: int) -> int:
        """Listen; return the port; raises `OSError` if it is taken."""
        self._server = await asyncio.start_server(self._connected, host, port)
        return int(self._server.sockets[0].getsockname()[1])

    async def stop(self) -> None:
        """Stop listening and close all connections."""
        if self._server is not None:
            self._server.close()
        for task in self._serving:
            task.cancel()
        if self._serving:
            await asyncio.wait(self._serving)

    def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self.clients >= MOST_CLIENTS:
            self._tell(f'a client is turned away: {MOST_CLIENTS} are connected')
            writer.close()
            return
        serving = asyncio.create_task(self._serve(reader, writer))
        self._serving.add(serving)
        serving.add_done_callback(self._serving.discard)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        pending: set[asyncio.Task[None]] = set()
        try:
            await self._read(reader, writer, pending)
        except ProtocolError as error:
            self._tell(f'a connection is closed: {error}')
        except (ConnectionError, asyncio.TimeoutError):
            pass
        finally:
            for task in pending:
                task.cancel()
            writer.close()

    async def _read(
        self,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        pending: set[asyncio.Task[None]],
    ) -> None:
        calls, sending = CallReader(), asyncio.Lock()
        # A connection without a call holds the place of a client.
        first_by_s: float | None = asyncio.get_running_loop().time() + READ_S
        while data := await _read_by(reader, first_by_s):
            for call in calls.feed(data):
                first_by_s = None
                if len(pending) >= MOST_PENDING:
                    # Scripts send orders in a loop: what comes faster than it is done waits in
                    # the connection.
                    await asyncio.wait(pending, return_when=asyncio.FIRST_COMPLETED)
                if writer.is_closing():
                    # Nobody reads the answers to the rest of its calls.
                    return
                task = asyncio.create_task(self._answer(call, writer, sending))
                pending.add(task)
                task.add_done_callback(pending.discard)
                task.add_done_callback(partial(self._ended, writer))

    def _ended(self, writer: asyncio.StreamWriter, task: asyncio.Task[None]) -> None:
        """Close the connection of a call that failed without an answer: its client would wait."""
        if not task.cancelled() and (error := task.exception()) is not None:
            self._tell(f'a connection is closed: a call has failed: {error!r}')
            writer.close()

    async def _answer(
        self, call: Call, writer: asyncio.StreamWriter, sending: asyncio.Lock
    ) -> None:
        try:
            result = await self._handle(call)
            told = answer(call.call_id or 0, result)
        except AirsimError as error:
            told = self._refused(call, f'{call.method}: {error}')
        except (TypeError, ValueError, KeyError, AttributeError, OverflowError) as error:
            # A parameter of the client has a wrong type.
            told = self._refused(call, f'{call.method}: wrong parameters: {error}')
        if call.call_id is None:
            return
        # The next answer waits until this one is read: images would fill the memory.
        async with sending:
            await self._send(told, writer)

    async def _send(self, told: bytes, writer: asyncio.StreamWriter) -> None:
        if writer.is_closing():
            return
        writer.write(told)
        try:
            await asyncio.wait_for(writer.drain(), READ_S)
        except ConnectionError:
            return
        except asyncio.TimeoutError:
            self._tell(f'a connection is closed: its client has read nothing for {READ_S:g} s')
            writer.transport.abort()

    def _refused(self, call: Call, text: str) -> bytes:
        """Return the refusal of a call.

        It is told too: a script that only waits for the end of an order does not see why.
        """
        line = text[:LONGEST_TOLD]
        if line not in self._refusals and len(self._refusals) < MOST_TOLD:
            self._refusals.add(line)
            self._tell(f'refused: {line}')
        return refusal(call.call_id or 0, text)


async def _read_by(reader: asyncio.StreamReader, time_s: float | None) -> bytes:
    """Return what comes next; raises `TimeoutError` if that is not by a time of the loop."""
    if time_s is None:
        return await reader.read(CHUNK)
    left_s = time_s - asyncio.get_running_loop().time()
    return await asyncio.wait_for(reader.read(CHUNK), max(left_s, 0.0))
