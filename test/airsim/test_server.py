# SPDX-License-Identifier: Apache-2.0
"""The TCP server by itself: what it tells people."""

import asyncio

import msgpack

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.protocol.server import MOST_TOLD, AirsimServer

DEADLINE_S = 20.0


def answers_to(calls, told):
    """Send calls of these names to a server that refuses all; return the answers."""

    async def refuse(call):
        raise AirsimError(f'not {call.arguments}')

    async def all_of_them():
        server = AirsimServer(refuse, told.append)
        port = await server.start('127.0.0.1', 0)
        reader, writer = await asyncio.open_connection('127.0.0.1', port)
        frames = [msgpack.packb([0, number, *call]) for number, call in enumerate(calls)]
        writer.write(b''.join(frames))
        unpacker, found = msgpack.Unpacker(), []
        while len(found) < len(calls):
            unpacker.feed(await reader.read(65_536))
            found += list(unpacker)
        writer.close()
        await server.stop()
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


def test_a_call_that_fails_closes_its_connection():
    """Nobody foresaw its error; its client would wait for ever."""
    told = []

    async def fail(_call):
        raise SystemError('a setter has failed')

    async def asked():
        server = AirsimServer(fail, told.append)
        reader, writer = await asyncio.open_connection(
            '127.0.0.1', await server.start('127.0.0.1', 0)
        )
        writer.write(msgpack.packb([0, 1, 'ping', []]))
        data = await reader.read()
        writer.close()
        await server.stop()
        return data

    assert asyncio.run(asyncio.wait_for(asked(), DEADLINE_S)) == b''
    assert told == [
        "a connection is closed: a call has failed: SystemError('a setter has failed')"
    ]
