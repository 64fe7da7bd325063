# SPDX-License-Identifier: Apache-2.0
"""The TCP server by itself: what it tells people."""

import asyncio

import msgpack
import pytest

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.protocol import server
from rocsafe_airsim.protocol.server import MOST_PENDING, MOST_TOLD, AirsimServer

DEADLINE_S = 20.0


def answers_to(calls, told):
    """Send calls of these names to a server that refuses all; return the answers."""

    async def refuse(call):
        raise AirsimError(f'not {call.arguments}')

    async def all_of_them():
        airsim = AirsimServer(refuse, told.append)
        port = await airsim.start('127.0.0.1', 0)
        reader, writer = await asyncio.open_connection('127.0.0.1', port)
        frames = [msgpack.packb([0, number, *call]) for number, call in enumerate(calls)]
        writer.write(b''.join(frames))
        unpacker, found = msgpack.Unpacker(), []
        while len(found) < len(calls):
            unpacker.feed(await reader.read(65_536))
            found += list(unpacker)
        writer.close()
        await airsim.stop()
        return found

    return asyncio.run(asyncio.wait_for(all_of_them(), DEADLINE_S))


def test_a_refusal_is_told_once_for_scripts_that_do_not_look():
    """Clients drop the refusal of an order whose end they only wait for."""
    told = []
    found = answers_to([('moveUp', [1]), ('moveUp', [1]), ('moveUp', [2])], told)
    assert [answer[2] for answer in found] == [
        'moveUp: not (1,)', 'moveUp: not (1,)', 'moveUp: not (2,)'
    ]  # fmt: skip
    assert told == ['refused: moveUp: not (1,)', 'refused: moveUp: not (2,)']


def test_a_flood_of_refusals_fills_no_log():
    """Of many different ones the first are told, each cut; all are answered."""
    told = []
    found = answers_to([('a', [number, 'x' * 2000]) for number in range(MOST_TOLD + 50)], told)
    assert len(found) == MOST_TOLD + 50
    assert len(told) == MOST_TOLD
    assert max(map(len, told)) < 400


@pytest.mark.slow
def test_a_client_that_reads_nothing_fills_no_memory_and_is_let_go(monkeypatch):
    """Of the images that it asks for, few are drawn; others are served meanwhile."""
    monkeypatch.setattr(server, 'READ_S', 1.0)
    told, drawn = [], []

    async def draw(_call):
        drawn.append(1)
        return bytes(1_000_000)

    async def asked():
        airsim = AirsimServer(draw, told.append)
        port = await airsim.start('127.0.0.1', 0)
        _, writer = await asyncio.open_connection('127.0.0.1', port, limit=1000)
        writer.write(b''.join(msgpack.packb([0, n, 'simGetImages', []]) for n in range(2000)))
        while not told:
            await asyncio.sleep(0.05)
        # Of the calls that it has sent none is carried out any more.
        left_over = len(drawn) + MOST_PENDING
        other, asking = await asyncio.open_connection('127.0.0.1', port)
        asking.write(msgpack.packb([0, 1, 'simGetImages', []]))
        assert await other.readexactly(1_000_000)
        await asyncio.sleep(0.5)
        assert len(drawn) <= left_over
        for one in (writer, asking):
            one.close()
        await airsim.stop()

    asyncio.run(asyncio.wait_for(asked(), DEADLINE_S))
    assert told == ['a connection is closed: its client has read nothing for 1 s']
    assert len(drawn) <= 2 * MOST_PENDING


def test_a_connection_without_a_call_keeps_no_place(monkeypatch):
    """Also one that sends a byte now and then; one that has called may be silent."""
    monkeypatch.setattr(server, 'READ_S', 0.5)
    monkeypatch.setattr(server, 'MOST_CLIENTS', 3)

    async def pong(_call):
        return True

    async def asked():
        airsim = AirsimServer(pong, print)
        port = await airsim.start('127.0.0.1', 0)
        caller = await asyncio.open_connection('127.0.0.1', port)
        caller[1].write(msgpack.packb([0, 1, 'ping', []]))
        await caller[0].readexactly(5)
        silent = await asyncio.open_connection('127.0.0.1', port)
        slow = await asyncio.open_connection('127.0.0.1', port)
        sent = msgpack.packb([0, 1, 'x' * 90, []])
        for byte in sent[:20]:
            if not slow[0].at_eof():
                slow[1].write(bytes([byte]))
                await asyncio.sleep(0.1)
        ends = [await silent[0].read(), await slow[0].read()]
        caller[1].write(msgpack.packb([0, 2, 'ping', []]))
        still = await caller[0].readexactly(5)
        for _, writer in (caller, silent, slow):
            writer.close()
        await airsim.stop()
        return ends, still, airsim.clients

    ends, still, _ = asyncio.run(asyncio.wait_for(asked(), DEADLINE_S))
    assert ends == [b'', b'']
    assert msgpack.unpackb(still) == [1, 2, None, True]


def test_an_end_closes_all_connections_without_an_error(caplog):
    """Also one whose call lasts; the library would report a task that ends cancelled."""

    async def last(_call):
        await asyncio.Event().wait()

    async def asked():
        airsim = AirsimServer(last, print)
        port = await airsim.start('127.0.0.1', 0)
        silent = await asyncio.open_connection('127.0.0.1', port)
        waiting = await asyncio.open_connection('127.0.0.1', port)
        waiting[1].write(msgpack.packb([0, 1, 'moveUp', []]))
        while airsim.clients < 2:
            await asyncio.sleep(0.01)
        await airsim.stop()
        ends = [await reader.read() for reader, _ in (silent, waiting)]
        for _, writer in (silent, waiting):
            writer.close()
        return ends, airsim.clients

    assert asyncio.run(asyncio.wait_for(asked(), DEADLINE_S)) == ([b'', b''], 0)
    assert not caplog.records


def test_a_call_that_fails_closes_its_connection():
    """Nobody foresaw its error; its client would wait for ever."""
    told = []

    async def fail(_call):
        raise SystemError('a setter has failed')

    async def asked():
        airsim = AirsimServer(fail, told.append)
        reader, writer = await asyncio.open_connection(
            '127.0.0.1', await airsim.start('127.0.0.1', 0)
        )
        writer.write(msgpack.packb([0, 1, 'ping', []]))
        data = await reader.read()
        writer.close()
        await airsim.stop()
        return data

    assert asyncio.run(asyncio.wait_for(asked(), DEADLINE_S)) == b''
    assert told == [
        "a connection is closed: a call has failed: SystemError('a setter has failed')"
    ]
