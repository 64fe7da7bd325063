# SPDX-License-Identifier: Apache-2.0
"""Clients that do not read, talk, or are too many: the picture goes on, for ROS and for others."""

import asyncio
import contextlib
import socket
import ssl
import time
from collections.abc import Callable
from dataclasses import replace
from urllib.request import urlopen

import aiohttp
import pytest
from test.console.caller import Caller
from test.console.stage import TOKEN, Stage, served
from test.console.test_tak_server import Authority

from rocsafe_console.errors import ConsoleError
from rocsafe_console.web import door, guards, push, server

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
    stuck = [upgrade(caller) for _ in range(SLOW)]
    until(lambda: len(clients) == SLOW, 'the slow pages are connected')
    with stage.context.live.lock:
        stage.context.live.picture.sections.put('decisions', LARGE)
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


def opened(address: str, head: bytes = b'') -> socket.socket:
    """Open a connection and send the beginning of a request, or nothing."""
    host, port = address.rsplit('/', 1)[0].split('//')[1].split(':')
    connection = socket.create_connection((host, int(port)), DEADLINE_S)
    connection.sendall(head)
    return connection


def is_open(connection: socket.socket) -> bool:
    """Return whether the server has kept a connection; what it has sent is read."""
    connection.settimeout(0.02)
    try:
        while connection.recv(2**16):
            pass
    except TimeoutError:
        return True
    except OSError:
        return False
    return False


def is_served(caller: Caller) -> bool:
    """Ask as a page does; nobody is let in while as many as there may be are being answered."""
    with contextlib.suppress(OSError):
        return bool(caller.ask('/api/hello')[0] == 200)
    return False


HALF = b'GET / HTTP/1.1\r\nHost: x\r\n'
SLOW_BODY = (
    b'POST /api/login HTTP/1.1\r\nHost: %s\r\nOrigin: http://%s\r\n'
    b'Content-Type: application/json\r\nContent-Length: 50\r\n\r\n{'
)
# Answers of 150 kB each, read by nobody.
UNREAD = b'GET /static/vendor/leaflet/leaflet.js HTTP/1.1\r\nHost: %s\r\n\r\n'


@pytest.mark.slow
@pytest.mark.parametrize(
    'head',
    [b'', HALF, SLOW_BODY, UNREAD * 40],
    ids=['no byte', 'half a head', 'half a body', 'answers that nobody reads'],
)
def test_requests_that_never_end_keep_no_page_out(tmp_path, monkeypatch, head):
    """However many there are, of one address: the oldest goes, a page waits for no deadline."""
    monkeypatch.setattr(door, 'MOST_OF_ADDRESS', 8)
    monkeypatch.setattr(door, 'HEAD_S', 600.0)
    with served(Stage(tmp_path)) as address:
        name = address.removeprefix('http://').rstrip('/').encode()
        idle = [opened(address, head.replace(b'%s', name)) for _ in range(40)]
        caller = Caller(address)
        until(lambda: is_served(caller), 'the page is served')
        assert caller.ask('/api/token', {'token': TOKEN})[0] == 200
        until(lambda: sum(map(is_open, idle)) <= 8, 'the oldest are closed')
        for connection in idle:
            connection.close()


def test_a_port_that_is_taken_is_told_in_one_line(tmp_path):
    """By its number and the reason, without that of Python; a host that is none, too."""
    with socket.create_server(('127.0.0.1', 0)) as taken:
        port = taken.getsockname()[1]
        text = f'--host 127.0.0.1 --port {port}: cannot be listened at: Address already in use'
        stage = Stage(tmp_path)
        stage.context.options = replace(stage.context.options, port=port)
        with pytest.raises(ConsoleError, match=f'^{text}$'):
            server.ServerThread(stage.context, print)
    with pytest.raises(ConsoleError, match=r'^--host no\.such\.host\.invalid --port 1: cannot be'):
        asyncio.run(door.listening_at('no.such.host.invalid', 1))


def test_a_page_is_not_closed_for_others_that_wait(live, monkeypatch):
    """Its live link stays, and new requests are still answered."""
    monkeypatch.setattr(door, 'MOST_OF_ADDRESS', 4)
    _, caller, clients = live
    link = upgrade(caller)
    until(lambda: len(clients) == 1, 'the page is connected')
    idle = [opened(caller.address + '/', HALF) for _ in range(20)]
    assert caller.ask('/api/hello')[0] == 200
    assert len(clients) == 1
    for connection in (link, *idle):
        connection.close()


def test_who_has_most_makes_room_where_there_are_too_many_together(tmp_path, monkeypatch):
    """Addresses count apart: 127.0.0.2 loses, not 127.0.0.1."""
    monkeypatch.setattr(door, 'MOST_CONNECTIONS', 10)
    with served(Stage(tmp_path)) as address:
        port = int(address.rstrip('/').rsplit(':', 1)[1])
        kept = opened(address, HALF)
        others = [
            socket.create_connection(('127.0.0.1', port), DEADLINE_S, ('127.0.0.2', 0))
            for _ in range(30)
        ]
        assert Caller(address).ask('/api/hello')[0] == 200
        until(lambda: sum(map(is_open, others)) <= 10, 'those of the other address are closed')
        assert is_open(kept)
        for connection in (kept, *others):
            connection.close()


def test_handshakes_that_never_end_keep_no_page_out(tmp_path, monkeypatch):
    """With TLS; they count before the server knows them, and are not waited for long."""
    monkeypatch.setattr(door, 'MOST_OF_ADDRESS', 8)
    authority, stage = Authority(tmp_path, 'authority'), Stage(tmp_path)
    pair = authority.issue('127.0.0.1')
    stage.context.options = replace(stage.context.options, certificate=pair, key=pair)
    with served(stage) as address:
        idle = [opened(address, b'\x16\x03') for _ in range(40)]
        trusted = ssl.create_default_context(cafile=str(authority.path))
        trusted.check_hostname = False
        with urlopen(f'{address}api/hello', context=trusted, timeout=DEADLINE_S) as answer:  # noqa: S310
            assert answer.status == 200
        until(lambda: sum(map(is_open, idle)) <= 8, 'the oldest are closed')
        monkeypatch.setattr(door, 'HEAD_S', 0.3)
        late = opened(address, b'\x16')
        until(lambda: not is_open(late), 'a handshake that takes too long is ended')
        for connection in (*idle, late):
            connection.close()


@pytest.mark.parametrize('head', [b'', HALF])
def test_a_head_that_does_not_come_is_not_waited_for(tmp_path, monkeypatch, head):
    """Nor does a byte now and then keep the connection."""
    monkeypatch.setattr(server, 'HEAD_S', 0.3)
    with served(Stage(tmp_path)) as address:
        connection = opened(address, head)
        end_s = time.monotonic() + 5.0
        while is_open(connection):
            assert time.monotonic() < end_s
            if head:
                with contextlib.suppress(OSError):
                    connection.sendall(b'X')
        connection.close()


def test_a_body_that_does_not_come_is_not_waited_for(tmp_path, monkeypatch):
    """The request is answered with 408."""
    monkeypatch.setattr(guards, 'BODY_S', 0.2)
    with served(Stage(tmp_path)) as address:
        name = address.removeprefix('http://').rstrip('/').encode()
        with opened(address, SLOW_BODY.replace(b'%s', name)) as connection:
            assert connection.recv(100).split(b' ')[1] == b'408'


@pytest.mark.parametrize(
    ('one', 'other', 'is_same'),
    [
        ('2001:db8:1:2::1', '2001:db8:1:2:ffff::9', True),
        ('2001:db8:1:2::1', '2001:db8:1:3::1', False),
        ('192.0.2.1', '192.0.2.2', False),
        ('fe80::1%eth0', 'fe80::2%eth0', True),
        ('::ffff:192.0.2.1', '::ffff:192.0.2.2', False),
    ],
)
def test_addresses_of_one_house_count_together(one, other, is_same):
    """Whoever has one address of IPv6 has 2**64."""
    assert (door.address_of((one, 1, 0, 0)) == door.address_of((other, 2, 0, 0))) is is_same
