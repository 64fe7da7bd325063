# SPDX-License-Identifier: Apache-2.0
"""Sends the picture to all pages, ten times a second, and alarms at once.

What all of them get is encoded once. A page that does not keep up gets less often, and then all
vehicles at once; it never slows others, nor ROS. Sections are never lost: each page gets those
that changed after the last ones it has.
"""

import asyncio
import contextlib
import json
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import partial

from aiohttp import web

from rocsafe_console.people.roles import MAY, Action
from rocsafe_console.people.sessions import Session
from rocsafe_console.picture.frame_bytes import VEHICLE, VehicleFrame, frame_of
from rocsafe_console.picture.sections import message_of
from rocsafe_console.web.context import Context, session_of

TICK_S = 0.1
REFRESH_TICKS = 5
FULL_TICKS = 10
SEND_S = 5.0
MOST_CLIENTS = 100
PING_S = 5.0
REVOKED = 4401
# Bytes of a vehicle before and after its age, which alone is no news.
_AGE = slice(18, 20)


@dataclass(slots=True, eq=False)
class Client:
    """A page that is connected."""

    socket: web.WebSocketResponse
    session: Session
    transport: asyncio.Transport | None
    change: int = 0
    missed: bool = True
    sees: bool = False
    wake: asyncio.Event = field(default_factory=asyncio.Event)
    parcel: list[str | bytes] = field(default_factory=list)
    is_sending: bool = False

    @property
    def is_busy(self) -> bool:
        """Whether what it was given before is still being sent."""
        return self.is_sending or len(self.parcel) > 1


class Pusher:
    """Sends the picture to the pages that are connected."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._clients: set[Client] = set()
        self._sequence = 0
        self._before: dict[int, bytes] = {}

    async def run(self) -> None:
        """Send until cancelled."""
        loop, ticks = asyncio.get_running_loop(), 0
        sections = self._context.live.picture.sections
        # Called by the thread of ROS, which may outlive this loop.
        sections.on_urgent = partial(_call_soon, loop, self._send_sections)
        while True:
            await asyncio.sleep(TICK_S)
            ticks += 1
            self._tick(is_full=ticks % FULL_TICKS == 0, is_refresh=ticks % REFRESH_TICKS == 0)

    async def serve(self, request: web.Request) -> web.WebSocketResponse:
        """Serve one page until it goes."""
        session = session_of(request, Action.SEE)
        socket = web.WebSocketResponse(heartbeat=PING_S, compress=False, max_msg_size=4096)
        await socket.prepare(request)
        if len(self._clients) >= MOST_CLIENTS:
            await socket.close(code=1013, message=b'too many pages are open')
            return socket
        client = Client(socket, session, request.transport)
        client.sees = self._is_seen_by(client)
        client.parcel.append(self._hello(client))
        client.wake.set()
        self._clients.add(client)
        sender = asyncio.create_task(self._send(client))
        try:
            # A page only listens: whoever talks is none, and is not read any further.
            await socket.receive()
        finally:
            self._clients.discard(client)
            # `wait_for` of Python 3.11 loses a cancellation that comes with its result.
            client.wake.set()
            sender.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await sender
        return socket

    async def close(self) -> None:
        """Close all pages' connections."""
        for client in list(self._clients):
            await client.socket.close(code=1001)

    def _is_seen_by(self, client: Client) -> bool:
        """Return whether the user of a page may see the mission that is heard."""
        access = self._context.missions.of(self._context.mission)
        return access.is_seen_by(client.session.user, client.session.role)

    def _hello(self, client: Client) -> str:
        """Return everything that a page needs to begin, and may see."""
        live, session = self._context.live, client.session
        may = sorted(action.value for action in MAY[session.role])
        user = {'user': session.user, 'role': session.role.value, 'may': may}
        if not client.sees:
            hidden = {'is_hidden': True, **user}
            return message_of({'session': json.dumps(hidden)}, 'hello')
        with live.lock:
            picture = live.picture
            picture.refresh()
            client.change = picture.sections.newest
            texts = dict(picture.sections.after(0))
            texts['tracks'] = picture.tracks_text()
        base = self._context.base_map
        texts['base_map'] = json.dumps(
            base and {'zooms': base.zooms, 'attribution': base.attribution, 'bounds': base.bounds}
        )
        texts['session'] = json.dumps(user)
        return message_of(texts, 'hello')

    def _tick(self, *, is_full: bool, is_refresh: bool) -> None:
        if not self._clients:
            return
        now_s = self._context.clock()
        live = self._context.live
        with live.lock:
            if is_refresh:
                self._context.end_former()
                live.picture.refresh()
                access = self._context.missions.of(self._context.mission)
                live.picture.sections.put('access', asdict(access))
            frames = live.picture.frames(now_s)
            mission_s = live.picture.clock.newest_s
        self._send_sections()
        nothing = frame_of([], self._sequence, now_s, math.nan)
        whole, delta = self._encoded(frames, now_s, mission_s, is_full=is_full)
        for client in list(self._clients):
            if not self._context.sessions.is_alive(client.session, now_s):
                self._clients.discard(client)
                asyncio.ensure_future(client.socket.close(code=REVOKED))  # noqa: RUF006
            elif client.is_busy:
                client.missed = True
            elif client.sees is not (sees := self._is_seen_by(client)):
                client.sees = sees
                client.parcel.append(self._hello(client))
                client.missed = True
                client.wake.set()
            elif not sees:
                client.parcel.append(nothing)
                client.wake.set()
            else:
                client.parcel.append(whole if client.missed else delta)
                client.missed = False
                client.wake.set()

    def _send_sections(self) -> None:
        """Give each page that keeps up the sections that it lacks."""
        with self._context.live.lock:
            sections = self._context.live.picture.sections
            newest = sections.newest
            waiting = [c for c in self._clients if c.sees and c.change < newest and not c.is_busy]
            texts = {c: message_of(sections.after(c)) for c in {one.change for one in waiting}}
        for client in waiting:
            client.parcel.append(texts[client.change])
            client.change = newest
            client.wake.set()

    def _encoded(
        self, frames: list[VehicleFrame], now_s: float, mission_s: float, *, is_full: bool
    ) -> tuple[bytes, bytes]:
        """Return the frame of all vehicles, and that of those that have news."""
        self._sequence += 1
        packed = {frame.number: frame.pack() for frame in frames}
        news = [
            data
            for number, data in packed.items()
            if is_full or not _is_same(self._before.get(number, b''), data)
        ]
        self._before = packed
        head = partial(frame_of, sequence=self._sequence, wall_s=now_s, mission_s=mission_s)
        return head(list(packed.values())), head(news)

    async def _send(self, client: Client) -> None:
        """Send what is put into the parcel of a client."""
        while client in self._clients:
            await client.wake.wait()
            client.wake.clear()
            parcel, client.parcel = client.parcel, []
            client.is_sending = True
            try:
                await asyncio.wait_for(_sent(client.socket, parcel), SEND_S)
            except (asyncio.TimeoutError, ConnectionError):
                self._clients.discard(client)
                if client.transport is not None:
                    client.transport.abort()
                return
            client.is_sending = False


async def _sent(socket: web.WebSocketResponse, parcel: list[str | bytes]) -> None:
    for part in parcel:
        if isinstance(part, str):
            await socket.send_str(part)
        else:
            await socket.send_bytes(part)


def _call_soon(loop: asyncio.AbstractEventLoop, task: Callable[[], object]) -> None:
    # The loop may have been closed meanwhile.
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(task)


def _is_same(before: bytes, data: bytes) -> bool:
    if len(before) != VEHICLE.size:
        return False
    return before[: _AGE.start] == data[: _AGE.start] and before[_AGE.stop :] == data[_AGE.stop :]


async def live(request: web.Request) -> web.StreamResponse:
    """Serve the live picture to a page."""
    return await request.app[PUSHER].serve(request)


PUSHER: web.AppKey[Pusher] = web.AppKey('pusher', Pusher)
