# SPDX-License-Identifier: Apache-2.0
"""The server of the page: routes, TLS, start and end."""

import asyncio
import gzip
import hashlib
import ipaddress
import logging
import ssl
from collections.abc import Callable, Coroutine
from functools import lru_cache, partial
from importlib import resources
from pathlib import Path
from threading import Event as Flag
from threading import Thread

from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError

from rocsafe_console.errors import ConsoleError
from rocsafe_console.outward.event_target import refuse_password
from rocsafe_console.runs.drafts import Drafts
from rocsafe_console.runs.jobs import Folders, Jobs
from rocsafe_console.web import (
    draft_handlers,
    handlers,
    job_handlers,
    order_handlers,
    outward_handlers,
    seal_handlers,
    video_handlers,
)
from rocsafe_console.web.context import CONTEXT, Context, WebOptions
from rocsafe_console.web.door import DOOR, HEAD_S, Door, listening_at
from rocsafe_console.web.event_sender import send_events
from rocsafe_console.web.guards import PORT, guard
from rocsafe_console.web.push import PUSHER, Pusher, live

MOST_BODY_BYTES = 2**20
MOST_PORT = 65535
STOP_S = 2.0
# After a fault that nobody has foreseen.
AGAIN_S = 1.0
_log = logging.getLogger(__name__)
STATIC = Path(str(resources.files('rocsafe_console').joinpath('static')))
VIEW = Path(str(resources.files('rocsafe_view').joinpath('static')))
TYPES = {
    '.js': 'text/javascript', '.css': 'text/css', '.html': 'text/html', '.svg': 'image/svg+xml',
    '.png': 'image/png', '.json': 'application/json', '.txt': 'text/plain',
}  # fmt: skip


def require_safe(options: WebOptions, user_count: int) -> None:
    """Refuse to be reached from other machines without TLS and users.

    Raises
    ------
    ConsoleError
        Naming what is missing.
    """
    if (options.certificate is None) != (options.key is None):
        raise ConsoleError('--certificate and --key: both are needed, or neither')
    if not 0 <= options.port <= MOST_PORT:
        raise ConsoleError(f'--port {options.port}: must be within 0 and {MOST_PORT}')
    if _is_loopback(options.host):
        return
    missing = [
        text
        for text, is_there in (
            ('--users', user_count > 0),
            ('--certificate and --key', options.certificate is not None),
        )
        if not is_there
    ]
    if missing:
        raise ConsoleError(f'host {options.host} is not loopback: needs {" and ".join(missing)}')


def make_app(context: Context, port: list[int]) -> web.Application:
    """Return the application; `port` holds the port once it is known."""
    options = context.options
    app = web.Application(middlewares=[guard], client_max_size=MOST_BODY_BYTES)
    app[CONTEXT] = context
    app[PUSHER] = Pusher(context)
    app[PORT] = port
    app[DOOR] = []
    app[seal_handlers.SEALING] = asyncio.Lock()
    app[draft_handlers.DRAFTS] = Drafts(options.runs, options.scenarios, context.environment)
    folders = Folders(runs=options.runs, scenarios=options.scenarios)
    app[job_handlers.JOBS] = Jobs(folders, context.environment)
    app.add_routes(ROUTES)
    return app


class ServerThread:
    """The server in a thread of its own.

    Raises
    ------
    ConsoleError
        If it cannot listen at its address, or its certificate is wrong.
    """

    def __init__(self, context: Context, say: Callable[[str], None]) -> None:
        self._context = context
        self._say = say
        self._loop = asyncio.new_event_loop()
        self._ready, self._stop = Flag(), asyncio.Event()
        self._fault: Exception | None = None
        self.port: list[int] = [context.options.port]
        self._thread = Thread(target=self._work, name='web', daemon=True)
        self._thread.start()
        self._ready.wait()
        if self._fault is not None:
            raise ConsoleError(str(self._fault)) from self._fault

    @property
    def address(self) -> str:
        """Address of the page."""
        options = self._context.options
        host = f'[{options.host}]' if ':' in options.host else options.host
        return f'{options.scheme}://{host}:{self.port[0]}/'

    def close(self) -> None:
        """End the server, and wait until it has ended."""
        self._loop.call_soon_threadsafe(self._stop.set)
        self._thread.join(timeout=2 * STOP_S)

    def _work(self) -> None:
        try:
            self._loop.run_until_complete(self._serve())
        except (ConsoleError, OSError, ValueError) as error:
            self._fault = error
        finally:
            self._ready.set()
            rest = asyncio.all_tasks(self._loop)
            for task in rest:
                task.cancel()
            if rest:
                self._loop.run_until_complete(asyncio.wait(rest, timeout=STOP_S))
            self._loop.close()

    async def _serve(self) -> None:
        options = self._context.options
        app = make_app(self._context, self.port)
        runner = web.AppRunner(
            app, access_log=None, shutdown_timeout=STOP_S, logger=_log, keepalive_timeout=HEAD_S
        )
        await runner.setup()
        if runner.server is None:
            raise ConsoleError('the server has not been set up')
        door = Door(runner.server, _tls(options))
        app[DOOR].append(door)
        sockets = await listening_at(options.host, options.port)
        self.port[0] = sockets[0].getsockname()[1]
        self._ready.set()
        accepting = (self._kept_up(partial(door.accept, one)) for one in sockets)
        works = (*self._work_of(app), *accepting)
        tasks = [asyncio.create_task(work) for work in works]
        await self._stop.wait()
        for task in tasks:
            task.cancel()
        await asyncio.wait(tasks)
        for listening in sockets:
            listening.close()
        door.close()
        await app[PUSHER].close()
        await runner.cleanup()

    def _work_of(self, app: web.Application) -> tuple[Coroutine[None, None, None], ...]:
        sent = partial(send_events, self._context, self._say)
        return self._kept_up(app[PUSHER].run), self._kept_up(sent)

    async def _kept_up(self, work: Callable[[], Coroutine[None, None, None]]) -> None:
        """Do `work` until cancelled: a fault is told, and ends neither the page nor the links."""
        told = ''
        while True:
            try:
                await work()
            except Exception as error:  # noqa: BLE001 - whatever it is, the picture goes on
                if (text := f'fault of the console: {type(error).__name__}: {error}') != told:
                    self._say(told := text)
            else:
                return
            await asyncio.sleep(AGAIN_S)


class _NoRequest(logging.Filter):
    """Drops what is logged of bytes that are no request: anybody could fill the log with it."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a record is kept."""
        error = record.exc_info[1] if record.exc_info else None
        return not isinstance(error, HttpProcessingError)


_log.addFilter(_NoRequest())


async def _index(request: web.Request) -> web.StreamResponse:
    return _file(request, STATIC / 'index.html')


async def _static(request: web.Request) -> web.StreamResponse:
    """Send a file of the page: of this package, or the style that it shares with the report."""
    name = request.match_info['path']
    for folder in (STATIC, VIEW):
        path = (folder / name).resolve()
        if path.is_relative_to(folder.resolve()) and path.suffix in TYPES and path.is_file():
            return _file(request, path)
    raise ConsoleError(f'{name!r}: there is none')


def _file(request: web.Request, path: Path) -> web.StreamResponse:
    """Send a file compressed; the browser asks each time, and is told if nothing has changed."""
    data, etag = _compressed(path, path.stat().st_mtime_ns)
    headers = {'Cache-Control': 'no-cache', 'ETag': f'"{etag}"', 'Vary': 'Accept-Encoding'}
    if request.headers.get('If-None-Match') == headers['ETag']:
        return web.Response(status=304, headers=headers)
    body = data
    if 'gzip' in request.headers.get('Accept-Encoding', ''):
        headers['Content-Encoding'] = 'gzip'
    else:
        body = gzip.decompress(data)
    kind = TYPES[path.suffix]
    charset = 'utf-8' if kind.startswith('text/') else None
    return web.Response(body=body, headers=headers, content_type=kind, charset=charset)


@lru_cache(maxsize=64)
def _compressed(path: Path, _changed_ns: int) -> tuple[bytes, str]:
    """Return the content of a file, compressed, and a hash of it; read again after a change."""
    data = path.read_bytes()
    return gzip.compress(data, mtime=0), hashlib.sha256(data).hexdigest()[:32]


def _tls(options: WebOptions) -> ssl.SSLContext | None:
    if options.certificate is None:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        # A key that asks for a password would wait for a terminal.
        context.load_cert_chain(options.certificate, options.key, password=refuse_password)
    except (OSError, ValueError) as error:
        reason = getattr(error, 'reason', None) or getattr(error, 'strerror', None) or error
        names = f'--certificate {options.certificate} and --key {options.key}'
        raise ConsoleError(f'{names}: cannot be used: {reason}') from error
    return context


def _is_loopback(host: str) -> bool:
    try:
        return host == 'localhost' or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


# What is asked for, and what answers.
ROUTES = (
    web.get('/', _index),
    web.get('/static/{path:.+}', _static),
    web.get('/api/hello', handlers.hello),
    web.post('/api/login', handlers.log_in),
    web.post('/api/token', handlers.use_token),
    web.post('/api/logout', handlers.log_out),
    web.get('/api/sessions', handlers.list_sessions),
    web.post('/api/sessions/{id}/revoke', handlers.revoke),
    web.get('/api/live', live),
    web.post('/api/orders', order_handlers.prepare_order),
    web.post('/api/orders/{id}/confirm', order_handlers.confirm_order),
    web.post('/api/alarms/{number}/acknowledge', handlers.acknowledge),
    web.post('/api/marks', handlers.mark),
    web.get('/api/coordinates', handlers.coordinates),
    web.get('/api/image/{name}', handlers.image),
    web.get(r'/api/base/{zoom:\d+}/{column:\d+}/{row:\d+}', handlers.base_tile),
    web.get('/api/photograph/{shot}', handlers.photograph),
    web.get('/api/video/{vehicle}', video_handlers.watch),
    web.get('/api/drafts', draft_handlers.list_drafts),
    web.get('/api/drafts/{kind}/{name}', draft_handlers.draft_text),
    web.post('/api/drafts', draft_handlers.save_draft),
    web.post('/api/drafts/{name}/plan', draft_handlers.plan_draft),
    web.post('/api/drafts/{name}/preflight', draft_handlers.preflight_draft),
    web.post('/api/drafts/{name}/launch', draft_handlers.launch_draft),
    web.get('/api/campaigns', job_handlers.list_campaigns),
    web.get('/api/campaigns/{name}/page', job_handlers.campaign_page),
    web.post('/api/jobs/{kind}/{name}', job_handlers.begin_job),
    web.get('/api/jobs/{kind}/{name}', job_handlers.look_at_job),
    web.post('/api/jobs/{kind}/{name}/end', job_handlers.end_job),
    web.post('/api/links', outward_handlers.make_link),
    web.get('/ogc/{secret}', outward_handlers.landing),
    web.get('/ogc/{secret}/', outward_handlers.landing),
    web.get('/ogc/{secret}/api', outward_handlers.definition),
    web.get('/ogc/{secret}/conformance', outward_handlers.conformance),
    web.get('/ogc/{secret}/collections', outward_handlers.collections),
    web.get('/ogc/{secret}/collections/{name}', outward_handlers.collection),
    web.get('/ogc/{secret}/collections/{name}/items', outward_handlers.items),
    web.get(r'/ogc/{secret}/collections/{name}/items/{number:\d{1,9}}', outward_handlers.item),
    web.post('/api/import', draft_handlers.import_areas),
    web.get('/api/missions/{name}', draft_handlers.mission_of_draft),
    web.post('/api/missions/{name}/end', draft_handlers.end_mission),
    web.get('/api/runs', handlers.list_runs),
    web.post('/api/runs/{run}/access', handlers.assign),
    web.get('/api/runs/{run}/verify', seal_handlers.verify),
    web.post('/api/runs/{run}/seal', seal_handlers.seal),
    web.get('/api/runs/{run}/replay', handlers.replay),
    web.get('/api/runs/{run}/files/{path:.+}', handlers.run_file),
)
