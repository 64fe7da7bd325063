# SPDX-License-Identifier: Apache-2.0
"""Handlers of new missions: draw, check, plan, approve, launch."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from functools import partial
from typing import ParamSpec, TypeVar

from aiohttp import web

from rocsafe_console.errors import RefusedError
from rocsafe_console.people.roles import Action
from rocsafe_console.people.sessions import Session
from rocsafe_console.runs.drafts import Drafts
from rocsafe_console.runs.outline import areas_of
from rocsafe_console.web.context import context_of, session_of
from rocsafe_console.web.guards import body_of

DRAFTS: web.AppKey[Drafts] = web.AppKey('drafts', Drafts)
# A plan takes up to two minutes: other requests, log-ins among them, do not wait for it.
STEPS = ThreadPoolExecutor(max_workers=2, thread_name_prefix='step')
Arguments = ParamSpec('Arguments')
Answer = TypeVar('Answer')


async def list_drafts(request: web.Request) -> web.Response:
    """List the scenarios to begin with, and the drafts."""
    session_of(request, Action.DRAFT)
    return web.json_response(request.app[DRAFTS].names())


async def draft_text(request: web.Request) -> web.Response:
    """Send the text of a scenario or draft."""
    session_of(request, Action.DRAFT)
    drafts = request.app[DRAFTS]
    text = drafts.text_of(request.match_info['kind'], request.match_info['name'])
    outline = await asyncio.to_thread(drafts.outline, text)
    return web.json_response({'text': text, 'outline': outline})


async def import_areas(request: web.Request) -> web.Response:
    """Send the polygons of a file that somebody imports."""
    session_of(request, Action.DRAFT)
    body = await body_of(request)
    areas = await asyncio.to_thread(areas_of, str(body['name']), str(body['text']))
    return web.json_response({'areas': areas})


async def save_draft(request: web.Request) -> web.Response:
    """Write a draft and check it."""
    context, body = context_of(request), await body_of(request)
    session = session_of(request, Action.DRAFT)
    drafts, name = request.app[DRAFTS], str(body['name'])
    text = drafts.save(name, str(body['text']), dict(body.get('drawn') or {}))
    await context.write('draft', session.user, name=name)
    step = await _step(drafts.check, name)
    outline = await asyncio.to_thread(drafts.outline, text)
    return web.json_response({**asdict(step), 'scenario': text, 'outline': outline})


async def plan_draft(request: web.Request) -> web.Response:
    """Plan a draft; the answer has what is to be approved."""
    session_of(request, Action.DRAFT)
    drafts, name = request.app[DRAFTS], request.match_info['name']
    step, plan, digest = await _step(drafts.plan, name)
    return web.json_response({**asdict(step), 'plan': plan, 'approve': digest})


async def preflight_draft(request: web.Request) -> web.Response:
    """Look at the real vehicles of a draft; nothing is commanded."""
    session_of(request, Action.DRAFT)
    step = await _step(request.app[DRAFTS].preflight, request.match_info['name'])
    return web.json_response(asdict(step))


async def launch_draft(request: web.Request) -> web.Response:
    """Launch exactly what was approved; it is written to the evidence log first."""
    context, body = context_of(request), await body_of(request)
    session = session_of(request, Action.LAUNCH)
    context.require_launches()
    name, approved = request.match_info['name'], str(body.get('approved', ''))
    confirmed = [str(one) for one in body.get('confirm', [])]
    try:
        await context.write(
            'launch', session.user, name=name, approved=approved, confirmed=confirmed
        )
    except OSError as error:
        raise RefusedError(f'nothing is launched: the evidence log: {error}') from error
    launch = await asyncio.to_thread(
        request.app[DRAFTS].launch, name, approved, session.user, confirmed
    )
    await context.write('outcome', session.user, name=name, **asdict(launch))
    return web.json_response(asdict(launch))


async def mission_of_draft(request: web.Request) -> web.Response:
    """Tell how the mission of a draft stands, and what it has printed."""
    _draft_session(request, Action.DRAFT)
    drafts, name = request.app[DRAFTS], request.match_info['name']
    return web.json_response(asdict(await asyncio.to_thread(drafts.mission, name)))


async def end_mission(request: web.Request) -> web.Response:
    """End the mission of a draft; it is written to the evidence log first."""
    context, name = context_of(request), request.match_info['name']
    session = _draft_session(request, Action.END)
    await context.write('end', session.user, name=name)
    request.app[DRAFTS].end(name)
    return web.json_response({})


def _draft_session(request: web.Request, action: Action) -> Session:
    """Return the session of a request whose user may do `action` to the mission of a draft.

    That may be another one than the mission that is heard: its own rights count.
    """
    session, context = session_of(request, action), context_of(request)
    access = request.app[DRAFTS].rights_on(request.match_info['name'], context.missions)
    access.require(session.user, session.role, action)
    return session


async def _step(
    work: Callable[Arguments, Answer], *given: Arguments.args, **more: Arguments.kwargs
) -> Answer:
    """Do a command of a draft in a thread that does nothing else."""
    loop = asyncio.get_running_loop()
    return await loop.run_in_executor(STEPS, partial(work, *given, **more))
