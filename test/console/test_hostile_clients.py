# SPDX-License-Identifier: Apache-2.0
"""Clients that do not read, talk, or are too many: the picture goes on, for ROS and for others."""

import asyncio
import socket
import time
from collections.abc import Callable

import aiohttp
import pytest
from test.console.caller import Caller
from test.console.stage import TOKEN, Stage, served

from rocsafe_console.web import push, server

DEADLINE_S = 30.0
SLOW = 20
# More than the buffers of a connection hold.
LARGE = 'x' * 8_000_000


def upgrade(caller: Caller) -> socket.socket:
    """Open a live connection that nobody reads."""
    host, port = caller.address.removeprefix('http://').split(':')
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    connection.connect((host, int(port)))
    lines = [
        'GET /api/live HTTP/1.1', f'Host: {host}:{port}', 'Upgrade: websocket',
        'Connection: Upgrade', 'Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==',
        'Sec-WebSocket-Version: 13', f'Origin: {caller.address}', f'Cookie: {caller.cookie}',
    ]  # fmt: skip
    connection.sendall('\r\n'.join([*lines, '', '']).encode())
    return connection


def until(condition: Callable[[], bool], what: str) -> None:
    """Wait for a condition of the server."""
    end_s = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < end_s, what
        time.sleep(0.02)


@pytest.fixture
def live(tmp_path, monkeypatch):
    """Return a mission with much to tell, a logged-in caller, and the pages that are connected."""
    pushers: list[push.Pusher] = []
    begin = push.Pusher.__init__

    def remember(self, context) -> None:
        begin(self, context)
        pushers.append(self)

    monkeypatch.setattr(push.Pusher, '__init__', remember)
    monkeypatch.setattr(push, 'SEND_S', 2.0)
    stage = Stage(tmp_path)
    stage.begin()
    with served(stage) as address:
        caller = Caller(address)
        caller.ask('/api/token', {'token': TOKEN})
        yield stage, caller, pushers[0]._clients


async def frames_read(caller: Caller, step: Callable[[], None], count: int) -> int:
    """Read as a page does, while the mission flies; return the number of frames."""
    found = 0
    headers = {'Origin': caller.address, 'Cookie': caller.cookie}
    async with (
        aiohttp.ClientSession(headers=headers) as session,
        session.ws_connect(f'{caller.address}/api/live', max_msg_size=0) as page,
    ):
        while found < count:
            step()
            message = await page.receive(timeout=DEADLINE_S)
            found += message.type is aiohttp.WSMsgType.BINARY
    return found


@pytest.mark.slow
def test_pages_that_do_not_read_slow_nobody_and_are_dropped(live):
    """ROS writes its picture meanwhile, another page gets its frames, memory is given back."""
    stage, caller, clients = live
    with stage.context.live.lock:
        stage.context.live.picture.sections.put('decisions', LARGE)
    stuck = [upgrade(caller) for _ in range(SLOW)]
    until(lambda: len(clients) == SLOW, 'the slow pages are connected')
    assert asyncio.run(frames_read(caller, stage.step, 5)) == 5
    assert max((len(client.parcel) for client in clients), default=0) <= 3
    until(lambda: not clients, 'the slow pages are dropped')
    for connection in stuck:
        connection.close()


def test_a_page_that_talks_is_none(live):
    """It is closed at its first word, however much more it sends."""
    _stage, caller, clients = live

    async def talk() -> aiohttp.WSMsgType:
        headers = {'Origin': caller.address, 'Cookie': caller.cookie}
        async with (
            aiohttp.ClientSession(headers=headers) as session,
            session.ws_connect(f'{caller.address}/api/live', max_msg_size=0) as page,
        ):
            await page.send_str('hello')
            while (message := await page.receive(timeout=DEADLINE_S)).type not in (
                aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED, aiohttp.WSMsgType.CLOSING,
            ):  # fmt: skip
                pass
            return message.type

    asyncio.run(talk())
    until(lambda: not clients, 'it is dropped')


@pytest.mark.parametrize(
    'head',
    [
        b'Content-Length: 4\r\nTransfer-Encoding: chunked',
        b'Content-Length: 4\r\nContent-Length: 6',
        b'Transfer-Encoding: xchunked',
        b'Host: evil.example',
        b'X: ' + b'a' * 100_000,
        b'X: a\r\n b',
    ],
    ids=['two lengths', 'length twice', 'coding', 'host twice', 'long', 'folded'],
)
def test_a_request_that_two_servers_would_read_in_two_ways_is_none(tmp_path, caplog, head):
    """It is refused and its connection closed; nothing is logged that anybody could repeat."""
    with served(Stage(tmp_path)) as address:
        host, port = address.removeprefix('http://').rstrip('/').split(':')
        with socket.create_connection((host, int(port)), DEADLINE_S) as connection:
            begin = f'POST /api/hello HTTP/1.1\r\nHost: {host}:{port}\r\n'.encode()
            connection.sendall(begin + head + b'\r\n\r\n0\r\n\r\n')
            answer = b''
            while part := connection.recv(4096):
                answer += part
        assert answer.split(b' ')[1] == b'400'
        assert answer.count(b'HTTP/1') == 1
        assert not caplog.records


def test_too_many_connections_are_closed_at_once(tmp_path, monkeypatch):
    """Half-open requests leave files for ROS; when they go, pages are served again."""
    monkeypatch.setattr(server, 'MOST_CONNECTIONS', 5)
    stage = Stage(tmp_path)
    with served(stage) as address:
        host, port = address.removeprefix('http://').rstrip('/').split(':')
        idle = []

        def is_refused() -> bool:
            """Open one more; return whether it is closed, by which nothing is read from it."""
            idle.append(socket.create_connection((host, int(port)), 0.2))
            try:
                idle[-1].sendall(b'GET / HTTP/1.1\r\nHost: x\r\n')
                return idle[-1].recv(1) == b''
            except TimeoutError:
                return False
            except ConnectionError:
                return True

        until(is_refused, 'one is refused')
        assert len(idle) == 6
        for connection in idle:
            connection.close()

        def is_served() -> bool:
            try:
                return Caller(address).ask('/api/hello')[0] == 200
            except OSError:
                return False

        until(is_served, 'it is served again')
