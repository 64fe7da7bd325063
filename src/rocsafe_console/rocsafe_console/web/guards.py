# SPDX-License-Identifier: Apache-2.0
"""What every request must pass: host, origin, form and session; and what every answer says."""

import asyncio
import json
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from aiohttp import web

from rocsafe_console.errors import ConsoleError, RefusedError, TooManyError
from rocsafe_console.web.context import ASKED, SESSION, WebOptions, context_of
from rocsafe_console.web.door import DOOR
from rocsafe_geo.evidence.evidence_log import EvidenceError

LOOPBACK_NAMES = ('127.0.0.1', 'localhost', '[::1]')
OPEN = frozenset({'/api/login', '/api/token', '/api/hello'})
POLICY = (
    "default-src 'self'; img-src 'self' data: blob:; media-src 'self' blob:; connect-src 'self'; "
    "worker-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'self'; "
    "object-src 'none'"
)
# A report brings its own script and its own policy; it has no origin, and so no session.
REPORT_POLICY = (
    "sandbox allow-scripts allow-modals; default-src 'none'; img-src data:; "
    "style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
)
HEADERS = {
    'Content-Security-Policy': POLICY,
    'X-Content-Type-Options': 'nosniff',
    'Referrer-Policy': 'no-referrer',
    'Cross-Origin-Opener-Policy': 'same-origin',
    'Cross-Origin-Resource-Policy': 'same-origin',
    'X-Frame-Options': 'DENY',
    'Permissions-Policy': 'camera=(), microphone=(), geolocation=()',
    'Cache-Control': 'no-store',
}
# HTTP status of each refusal, by the first kind that fits. OSError is mostly a full disk.
STATUSES: Mapping[type[Exception], int] = {
    TooManyError: 429, RefusedError: 403, ConsoleError: 404, FileNotFoundError: 404,
    EvidenceError: 503, OSError: 503,
    ValueError: 400, LookupError: 400, TypeError: 400, ArithmeticError: 400, AttributeError: 400,
}  # fmt: skip
BODY_S = 10.0
FORBIDDEN = 403
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


def hosts_of(options: WebOptions, port: int) -> frozenset[str]:
    """Return what the header Host may be: a page of another name that leads here has another."""
    names = {*LOOPBACK_NAMES, *options.names, options.host}
    return frozenset({f'{name}:{port}' for name in names} | names)


@web.middleware
async def guard(request: web.Request, handler: Handler) -> web.StreamResponse:
    """Let a request pass that comes from the page itself and from somebody who is logged in."""
    with request.app[DOOR][0].serving(request.protocol):
        return await _guarded(request, handler)


async def _guarded(request: web.Request, handler: Handler) -> web.StreamResponse:
    try:
        refusal = _refusal(request)
        answer = refusal if refusal is not None else await handler(request)
    except RecursionError:
        answer = refused(400, 'the body is nested too deeply')
    except web.HTTPException as error:
        answer = refused(error.status, error.reason)
    except tuple(STATUSES) as error:
        status = next(code for kind, code in STATUSES.items() if isinstance(error, kind))
        if status == FORBIDDEN and SESSION in request and request.method != 'GET':
            asked = request.get(ASKED)
            context = context_of(request)
            await context.note_refusal(request[SESSION], request.path, str(error), asked)
        answer = refused(status, str(error) or type(error).__name__)
    if not answer.prepared:
        for name, value in HEADERS.items():
            answer.headers.setdefault(name, value)
    return answer


def refused(status: int, text: str) -> web.Response:
    """Return a refusal with its reason."""
    return web.json_response({'error': text}, status=status)


async def body_of(request: web.Request) -> dict[str, Any]:
    """Return the JSON object in a request; raises `ValueError` or `TypeError`."""
    try:
        content = json.loads(await asyncio.wait_for(request.text(), BODY_S))
    except asyncio.TimeoutError as error:
        raise web.HTTPRequestTimeout(
            reason=f'the body did not come within {BODY_S:g} s'
        ) from error
    if not isinstance(content, dict):
        raise TypeError('the body must be a JSON object')
    return content


def _refusal(request: web.Request) -> web.Response | None:
    """Return why a request does not pass, None if it does."""
    context = context_of(request)
    host = request.headers.get('Host', '')
    port = request.app[PORT][0]
    if host not in hosts_of(context.options, port):
        return refused(421, f'this page is not served as {host!r}: name it by --name')
    is_socket = request.headers.get('Upgrade', '').lower() == 'websocket'
    if request.method not in ('GET', 'HEAD') or is_socket:
        if request.headers.get('Origin') != f'{context.options.scheme}://{host}':
            return refused(403, 'the request does not come from this page')
        if not is_socket and request.content_type != 'application/json':
            return refused(415, 'the body must be application/json')
    is_link = request.path.startswith('/ogc/')
    if not (is_link or request.path.startswith('/api/')) or request.path in OPEN:
        return None
    cookie = request.cookies.get(context.options.cookie, '')
    context.end_former()
    # A link is for programs that cannot log in; it opens nothing else.
    secret = request.path.split('/')[2] if is_link else cookie
    session = context.sessions.of_secret(secret, context.clock())
    if session is None:
        return refused(401, 'log in first')
    if is_link is not session.is_link:
        return refused(401, 'this is no link' if is_link else 'log in first')
    request[SESSION] = session
    return None


PORT: web.AppKey[list[int]] = web.AppKey('port', list)
