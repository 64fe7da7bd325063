# SPDX-License-Identifier: Apache-2.0
"""Handlers of requests: log-in, alarms, marks, pictures and runs."""

import asyncio
import hmac
import math
from dataclasses import asdict
from typing import Any

from aiohttp import web

from rocsafe_console.errors import ConsoleError
from rocsafe_console.people.missions import access_of
from rocsafe_console.people.roles import MAY, Action
from rocsafe_console.people.sessions import Session
from rocsafe_console.picture.alarms import WARN
from rocsafe_console.picture.coordinates import coordinates_of
from rocsafe_console.picture.places import place_of_text
from rocsafe_console.runs.run_folder import (
    EMPTY_TILE,
    file_of,
    is_tile,
    replay_of,
    run_in,
    runs_in,
)
from rocsafe_console.web.context import (
    Context,
    context_of,
    limited,
    local_session,
    mission_session,
    session_of,
)
from rocsafe_console.web.guards import REPORT_POLICY, body_of, refused
from rocsafe_geo.evidence.evidence_log import line_of

MOST_TEXT, MOST_MARKS = 500, 1000


async def hello(request: web.Request) -> web.Response:
    """Tell whether users log in or a token opens the page, and who is logged in."""
    context = context_of(request)
    secret = request.cookies.get(context.options.cookie, '')
    session = context.sessions.of_secret(secret, context.clock())
    return web.json_response(
        {'needs': 'token' if context.options.token else 'login', **_session_plain(session)}
    )


async def log_in(request: web.Request) -> web.Response:
    """Begin a session by name and password; attempts are limited by name and by address."""
    context, body = context_of(request), await body_of(request)
    name, password = str(body.get('name', '')), str(body.get('password', ''))
    address, now_s = request.remote or '', context.clock()
    context.end_former()
    wait_s = max(context.logins.wait_s(key, now_s) for key in (f'n {name}', f'a {address}'))
    if wait_s:
        return refused(429, f'too many attempts: wait {math.ceil(wait_s)} s')
    for key in (f'n {name}', f'a {address}'):
        context.logins.note(key, now_s)
    # Argon2 takes a tenth of a second and 64 MiB; the loop must not wait for it.
    user = await asyncio.to_thread(context.users.log_in, name, password)
    if user is None:
        await _note(context, 'login', name[:64], address=address, outcome='refused')
        return refused(401, 'the name or the password is not right')
    context.logins.forgive(f'n {name}')
    await _note(context, 'login', user.name, address=address, outcome='done', role=user.role.value)
    begun = context.sessions.begin(user.name, user.role, address, context.clock())
    return _with_cookie(context, *begun)


async def use_token(request: web.Request) -> web.Response:
    """Begin the session of whoever started the console, by its token."""
    context, body = context_of(request), await body_of(request)
    address, now_s = request.remote or '', context.clock()
    if context.logins.wait_s(f'a {address}', now_s):
        return refused(429, 'too many attempts')
    token = context.options.token
    if not token or not hmac.compare_digest(str(body.get('token', '')).encode(), token.encode()):
        context.logins.note(f'a {address}', now_s)
        return refused(
            401, 'the token is not right: take the address that the console has printed'
        )
    await _note(context, 'login', context.options.token_user, address=address, outcome='done')
    return _with_cookie(context, *local_session(context, address))


async def log_out(request: web.Request) -> web.Response:
    """End the session."""
    context, session = context_of(request), session_of(request, Action.SEE)
    context.sessions.end(session.public_id)
    context.save_sessions()
    await _note(context, 'logout', session.user)
    answer = web.json_response({})
    answer.del_cookie(context.options.cookie)
    return answer


async def list_sessions(request: web.Request) -> web.Response:
    """List who is logged in."""
    context = context_of(request)
    own = session_of(request, Action.REVOKE)
    plain = [
        {**asdict(one), 'role': one.role.value, 'is_own': one.public_id == own.public_id}
        for one in context.sessions.all(context.clock())
    ]
    return web.json_response({'sessions': plain})


async def revoke(request: web.Request) -> web.Response:
    """End somebody's session."""
    context, session = context_of(request), session_of(request, Action.REVOKE)
    public_id = request.match_info['id']
    await _note(context, 'revoke', session.user, session=public_id)
    if not context.sessions.end(public_id):
        raise ConsoleError(f'session {public_id}: there is none')
    context.save_sessions()
    return web.json_response({})


async def acknowledge(request: web.Request) -> web.Response:
    """Note that somebody has seen an alarm."""
    context, session = context_of(request), mission_session(request, Action.ACKNOWLEDGE)
    number = int(request.match_info['number'])
    with context.live.lock:
        alarm = context.live.picture.alarms.of(number)
    await context.write('acknowledge', session.user, alarm=alarm.text, number=number)
    with context.live.lock:
        context.live.picture.acknowledge(number, session.user, context.clock())
    return web.json_response({})


async def mark(request: web.Request) -> web.Response:
    """Mark a place as evidence, with a note."""
    context, body = context_of(request), await body_of(request)
    session = mission_session(request, Action.MARK)
    limited(request, session)
    latitude_deg, longitude_deg = float(body['latitude_deg']), float(body['longitude_deg'])
    forms, text = coordinates_of(latitude_deg, longitude_deg), str(body.get('text', ''))
    if not text.strip() or len(text) > MOST_TEXT:
        raise ValueError(f'text has {len(text)} letters: must have 1 to {MOST_TEXT}')
    with context.live.lock:
        sections = context.live.picture.sections
        if len(sections.value('marks') or []) >= MOST_MARKS:
            raise ValueError(f'marks: there are {MOST_MARKS} already, which is the most')
    place = {'latitude_deg': latitude_deg, 'longitude_deg': longitude_deg, 'datum': 'WGS84'}
    await context.write('mark', session.user, **place, mgrs=forms.mgrs, text=text)
    with context.live.lock:
        sections = context.live.picture.sections
        marks = sections.value('marks') or []
        one = {**place, 'text': text, 'by': session.user, 'time_s': context.clock()}
        sections.put('marks', [*marks, one])
    return web.json_response({}, status=201)


async def coordinates(request: web.Request) -> web.Response:
    """Tell a place in all forms: of a click, or as it was typed."""
    session_of(request, Action.SEE)
    if (text := request.query.get('text')) is not None:
        place = place_of_text(text)
        return web.json_response({'place': place, **asdict(coordinates_of(*place))})
    forms = coordinates_of(float(request.query['latitude']), float(request.query['longitude']))
    return web.json_response(asdict(forms))


async def image(request: web.Request) -> web.Response:
    """Send the dose map, the plume or the mosaic as it is now."""
    mission_session(request, Action.SEE)
    live = context_of(request).live
    with live.lock:
        data = live.images.get(request.match_info['name'])
    if data is None:
        raise ConsoleError('there is none yet')
    return web.Response(body=data, content_type='image/png')


async def base_tile(request: web.Request) -> web.Response:
    """Send a tile of the base map; a transparent one where there is none."""
    session_of(request, Action.SEE)
    base = context_of(request).base_map
    if base is None:
        raise ConsoleError('there is no base map')
    place = (int(request.match_info[key]) for key in ('zoom', 'column', 'row'))
    data = await asyncio.to_thread(base.tile, *place)
    if data is None:
        return web.Response(body=EMPTY_TILE, content_type='image/png')
    return web.Response(body=data, content_type=base.content_type)


async def photograph(request: web.Request) -> web.StreamResponse:
    """Send a stored photograph."""
    mission_session(request, Action.SEE)
    live = context_of(request).live
    with live.lock:
        path = live.photographs.get(request.match_info['shot'])
    if path is None or path.suffix.lower() not in ('.jpg', '.jpeg') or not path.is_file():
        raise ConsoleError('this photograph is not on this machine')
    return web.FileResponse(path)


async def list_runs(request: web.Request) -> web.Response:
    """List the missions in the folder that the user may see, with who commands them."""
    session, context = session_of(request, Action.SEE), context_of(request)
    rows = await asyncio.to_thread(runs_in, context.options.runs)
    seen = []
    for row in rows:
        access = context.missions.of(row['name'])
        if access.is_seen_by(session.user, session.role):
            seen.append({**row, **asdict(access)})
    return web.json_response({'runs': seen})


async def assign(request: web.Request) -> web.Response:
    """Set who commands a mission, who sees it, and who gives orders."""
    session, context = session_of(request, Action.ASSIGN), context_of(request)
    run = run_in(context.options.runs, request.match_info['run'])
    access = access_of(await body_of(request))
    unknown = context.users.unknown((access.commander, *access.members))
    if unknown:
        raise ValueError(f'user {unknown[0]!r}: there is none')
    await context.write('assign', session.user, run.name, mission=run.name, **asdict(access))
    context.missions.put(run.name, access)
    return web.json_response({})


async def replay(request: web.Request) -> web.Response:
    """Send what the page needs to replay a run."""
    run = run_in(context_of(request).options.runs, request.match_info['run'])
    mission_session(request, Action.SEE, run.name)
    # Megabytes: encoded in the thread, too.
    text = await asyncio.to_thread(lambda: line_of(replay_of(run)))
    return web.Response(body=text, content_type='application/json')


async def run_file(request: web.Request) -> web.StreamResponse:
    """Send a file of a run."""
    run = run_in(context_of(request).options.runs, request.match_info['run'])
    mission_session(request, Action.SEE, run.name)
    name = request.match_info['path']
    if is_tile(name) and not (run / name).is_file():
        return web.Response(body=EMPTY_TILE, content_type='image/png')
    path = file_of(run, name)
    answer = web.FileResponse(path)
    if path.name == 'report.html':
        answer.headers['Content-Security-Policy'] = REPORT_POLICY
    return answer


async def _note(context: Context, kind: str, by: str, /, **what: object) -> None:
    """Write who comes and goes; where that is not possible, an alarm tells it.

    A full disk keeps nobody out who must hold a vehicle, and no thief in.
    """
    if unlogged := await context.note(kind, by, **what):
        with context.live.lock:
            text = f'{kind} of {by} is in no evidence log: {unlogged}'
            context.live.picture.alarm(context.clock(), WARN, '', text)


def _session_plain(session: Session | None) -> dict[str, Any]:
    if session is None:
        return {'user': None}
    may = sorted(action.value for action in MAY[session.role])
    return {'user': session.user, 'role': session.role.value, 'may': may}


def _with_cookie(context: Context, secret: str, session: Session) -> web.Response:
    context.save_sessions()
    answer = web.json_response(_session_plain(session))
    answer.set_cookie(
        context.options.cookie,
        secret,
        path='/',
        httponly=True,
        samesite='Strict',
        secure=context.options.certificate is not None,
    )
    return answer
