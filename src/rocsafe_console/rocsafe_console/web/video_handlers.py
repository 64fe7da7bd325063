# SPDX-License-Identifier: Apache-2.0
"""Pictures of a camera, as a page wants to look at it: the newest ones, some a second."""

import asyncio
import contextlib

from aiohttp import web

from rocsafe_console.errors import ConsoleError
from rocsafe_console.people.roles import Action
from rocsafe_console.people.sessions import Session
from rocsafe_console.picture.video import SCENE
from rocsafe_console.web.context import Context, context_of, mission_session

# Most that is sent to a page; what comes faster is left out.
PERIOD_S = 0.2
SEND_S = 5.0
PING_S = 5.0


async def watch(request: web.Request) -> web.WebSocketResponse:
    """Send the newest pictures of a vehicle's camera until the page goes."""
    context, session = context_of(request), mission_session(request, Action.SEE)
    vehicle = request.match_info['vehicle']
    with context.live.lock:
        if vehicle != SCENE and vehicle not in context.live.picture.vehicles:
            raise ConsoleError(f'vehicle {vehicle}: there is none')
        if not context.live.video.join(vehicle):
            raise ConsoleError('too many pages look at cameras')
    try:
        socket = web.WebSocketResponse(heartbeat=PING_S, compress=False, max_msg_size=4096)
        await socket.prepare(request)
        sender = asyncio.create_task(_send(context, session, vehicle, socket))
        # A page only listens: its first word or its end ends this.
        await asyncio.wait(
            (sender, asyncio.create_task(_ended(socket))), return_when=asyncio.FIRST_COMPLETED
        )
        sender.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await sender
    finally:
        with context.live.lock:
            context.live.video.leave(vehicle)
    return socket


async def _ended(socket: web.WebSocketResponse) -> None:
    await socket.receive()


async def _send(
    context: Context, session: Session, vehicle: str, socket: web.WebSocketResponse
) -> None:
    """Send until the page is too slow, its session has ended, or it is cancelled."""
    sent = 0
    while context.sessions.is_alive(session, context.clock()):
        with context.live.lock:
            newest = context.live.video.newest(vehicle)
        if newest is not None and newest.number != sent:
            sent = newest.number
            try:
                await asyncio.wait_for(socket.send_bytes(newest.pack()), SEND_S)
            except (asyncio.TimeoutError, ConnectionError):
                return
        if socket.closed:
            return
        await asyncio.sleep(PERIOD_S)
