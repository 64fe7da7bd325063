# SPDX-License-Identifier: Apache-2.0
"""An attacker who sends very many requests: forged, replayed, from other sites, and broken."""

import asyncio
import json
import random
from collections.abc import Mapping

import aiohttp

from rocsafe_console.people.roles import VERBS

AT_ONCE = 40
# Each has at least one thing wrong for an order of the page itself.
ALIEN: list[Mapping[str, str]] = [
    {'Origin': 'http://evil.example'},
    {'Origin': 'null'},
    {'Origin': ''},
    {'Host': 'evil.example'},
    {'Host': '127.0.0.1.evil.example'},
    {'Content-Type': 'text/plain'},
    {'Content-Type': 'application/x-www-form-urlencoded'},
    {'Content-Type': 'multipart/form-data; boundary=x'},
]
WRONG_COOKIES = ('', 'x', '=', 'rocsafe=x')


class Forger:
    """Makes requests of which none may be obeyed.

    Parameters
    ----------
    address
        Of the page, without a slash at the end.
    cookie
        Of a session that is alive.
    revisions
        Of the vehicles.
    used
        Id of an order that has been confirmed by this session.
    """

    def __init__(
        self, address: str, cookie: str, revisions: Mapping[str, int], used: str, seed: int = 1
    ) -> None:
        self._address, self._cookie, self._used = address, cookie, used
        self._revisions = dict(revisions)
        self._source = random.Random(seed)

    def request(self) -> tuple[str, str, dict[str, str], bytes]:
        """Return method, path, headers and body."""
        source = self._source
        headers = {
            'Origin': self._address,
            'Content-Type': 'application/json',
            'Cookie': self._cookie,
        }
        order_id = f'{source.getrandbits(128):032x}'
        order = {
            'request_id': order_id,
            'verb': source.choice(sorted(verb.value for verb in VERBS)),
            'revisions': self._revisions,
        }
        body, method = json.dumps(order).encode(), 'POST'
        path = source.choice(('/api/orders', f'/api/orders/{order_id}/confirm'))
        kind = source.randrange(6)
        if kind == 0:
            headers |= source.choice(ALIEN)
        elif kind == 1:
            headers['Cookie'] = source.choice((*WRONG_COOKIES, self._bent(self._cookie)))
        elif kind == 2:
            # Told once more, by whoever has heard all of it.
            path = f'/api/orders/{self._used}/confirm'
        elif kind == 3:
            path = f'/api/orders/{order_id}/confirm'
        elif kind == 4:
            method, path = source.choice(('GET', 'PUT', 'DELETE', 'PATCH')), '/api/orders'
        else:
            path, body = '/api/orders', self._bent(body.decode()).encode(errors='replace')[:-1]
        return method, path, headers, body

    def _bent(self, text: str) -> str:
        """Return a text with one letter changed."""
        at = self._source.randrange(len(text))
        return text[:at] + chr(33 + (ord(text[at]) - 32) % 94) + text[at + 1 :]


async def forge(forger: Forger, address: str, count: int) -> dict[int, int]:
    """Send `count` forged requests and return how often each status was answered."""
    statuses: dict[int, int] = {}
    left = iter(range(count))
    async with aiohttp.ClientSession(cookie_jar=aiohttp.DummyCookieJar()) as session:

        async def work() -> None:
            for _ in left:
                method, path, headers, body = forger.request()
                url = f'{address}{path}'
                async with session.request(method, url, headers=headers, data=body) as answer:
                    await answer.read()
                    statuses[answer.status] = statuses.get(answer.status, 0) + 1

        await asyncio.gather(*(work() for _ in range(AT_ONCE)))
    return statuses
