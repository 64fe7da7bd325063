# SPDX-License-Identifier: Apache-2.0
"""Somebody who asks the server: as a page does, or as an attacker."""

import json
import secrets
import urllib.error
import urllib.request
from http.cookies import SimpleCookie


class Caller:
    """Asks the server as a page does."""

    def __init__(self, address: str) -> None:
        self.address = address.rstrip('/')
        self.cookie = ''

    def ask(self, path: str, body: object = None, **headers: str) -> tuple[int, dict]:
        """Return status and answer; None of `body`: GET."""
        given = {'Origin': self.address, 'Cookie': self.cookie, **headers}
        data = None
        if body is not None:
            data = body if isinstance(body, bytes) else json.dumps(body).encode()
            given = {'Content-Type': 'application/json', **given}
        given = {name: value for name, value in given.items() if value != 'none'}
        request = urllib.request.Request(self.address + path, data=data, headers=given)  # noqa: S310
        try:
            with urllib.request.urlopen(request, timeout=20) as answer:  # noqa: S310
                return self._read(answer)
        except urllib.error.HTTPError as error:
            return self._read(error)

    def _read(self, answer) -> tuple[int, dict]:
        self.headers = answer.headers
        jar = SimpleCookie(answer.headers.get('Set-Cookie', ''))
        if jar:
            name, morsel = next(iter(jar.items()))
            self.cookie = f'{name}={morsel.value}'
            self.set_cookie = answer.headers['Set-Cookie']
        data = answer.read()
        is_json = answer.headers.get_content_type() in ('application/json', 'application/geo+json')
        return answer.status, json.loads(data) if is_json else {}

    def order(self, verb: str, revisions: dict[str, int], **more: object) -> tuple[int, dict]:
        """Prepare and confirm an order."""
        request_id = secrets.token_hex(16)
        body = {'request_id': request_id, 'verb': verb, 'revisions': revisions, **more}
        status, answer = self.ask('/api/orders', body)
        if status != 201:
            return status, answer
        return self.ask(f'/api/orders/{request_id}/confirm', {})


def revisions_of(stage) -> dict[str, int]:
    """Return the revision of each vehicle now."""
    return {name: one.revision for name, one in stage.context.live.picture.vehicles.items()}


FORGED = [
    {'Origin': 'http://evil.example'},
    {'Origin': 'none'},
    {'Origin': 'null'},
    {'Host': 'evil.example'},
    {'Content-Type': 'text/plain'},
    {'Content-Type': 'application/x-www-form-urlencoded'},
    {'Cookie': 'none'},
    {'Cookie': 'rocsafe=x'},
]
