# SPDX-License-Identifier: Apache-2.0
"""Pictures of cameras: only of those that somebody looks at, and only the newest."""

import asyncio
import time
from io import BytesIO

import aiohttp
import pytest
from PIL import Image
from test.console.caller import Caller
from test.console.stage import TOKEN, Stage, served

from rocsafe_console.picture.video import HEAD, MOST_BYTES, MOST_WATCHERS, Video

DEADLINE_S = 20.0


def jpeg_of(red: int) -> bytes:
    """Return a small picture."""
    buffer = BytesIO()
    Image.new('RGB', (64, 48), (red, 0, 0)).save(buffer, 'JPEG')
    return buffer.getvalue()


def test_what_nobody_looks_at_is_neither_wanted_nor_kept():
    """Two look, one leaves, then the other."""
    video = Video()
    video.put('rav1', jpeg_of(1), 1.0)
    assert video.newest('rav1') is None
    assert video.join('rav1')
    assert video.join('rav1')
    video.put('rav1', jpeg_of(2), 2.0)
    video.leave('rav1')
    assert video.wanted == {'rav1'}
    assert video.newest('rav1').jpeg == jpeg_of(2)
    video.leave('rav1')
    assert video.wanted == frozenset()
    assert video.newest('rav1') is None


def test_an_older_picture_or_no_picture_changes_nothing():
    """As DDS may send what it has kept; also what is too large."""
    video = Video()
    video.join('rav1')
    video.put('rav1', jpeg_of(3), 10.0)
    for data, taken_s in (
        (jpeg_of(4), 9.0), (b'no picture', 11.0), (b'', 11.0),
        (jpeg_of(4) + bytes(MOST_BYTES), 11.0),
    ):  # fmt: skip
        video.put('rav1', data, taken_s)
    assert video.newest('rav1').taken_s == 10.0


def test_only_so_many_look_at_a_time():
    """Each costs what a camera sends."""
    video = Video()
    assert all(video.join(f'rav{number}') for number in range(MOST_WATCHERS))
    assert not video.join('rav1')
    video.leave('rav2')
    assert video.join('rav1')


@pytest.fixture
def watched(tmp_path):
    """Return a mission and somebody who is logged in."""
    stage = Stage(tmp_path)
    stage.begin()
    with served(stage) as address:
        caller = Caller(address)
        caller.ask('/api/token', {'token': TOKEN})
        yield stage, caller


def test_a_page_gets_the_newest_pictures_and_ends_the_stream_by_going(watched):
    """Of many between two sendings, one; a picture is not sent twice."""
    stage, caller = watched
    live = stage.context.live
    headers = {'Origin': caller.address, 'Cookie': caller.cookie}

    async def look() -> list[tuple[float, bytes]]:
        found = []
        async with (
            aiohttp.ClientSession(headers=headers) as session,
            session.ws_connect(f'{caller.address}/api/video/rav1') as page,
        ):
            for turn in range(3):
                with live.lock:
                    for number in range(50):
                        live.video.put('rav1', jpeg_of(number), 100.0 * turn + number)
                data = (await page.receive(timeout=DEADLINE_S)).data
                found.append((HEAD.unpack_from(data)[0], data[HEAD.size :]))
        return found

    assert asyncio.run(look()) == [(100.0 * turn + 49, jpeg_of(49)) for turn in range(3)]
    end_s = time.monotonic() + DEADLINE_S
    while live.video.wanted:
        assert time.monotonic() < end_s, 'the stream has not ended'
        time.sleep(0.02)


def test_who_may_not_look_gets_no_stream(watched):
    """Nobody's session, another origin, or no such vehicle."""
    _stage, caller = watched
    upgrade = {
        'Upgrade': 'websocket', 'Connection': 'Upgrade', 'Sec-WebSocket-Version': '13',
        'Sec-WebSocket-Key': 'AAAAAAAAAAAAAAAAAAAAAA==',
    }  # fmt: skip
    assert caller.ask('/api/video/rav9', **upgrade)[0] == 404
    assert caller.ask('/api/video/rav1', **upgrade, Cookie='none')[0] == 401
    assert caller.ask('/api/video/rav1', **upgrade, Origin='http://evil.example')[0] == 403
