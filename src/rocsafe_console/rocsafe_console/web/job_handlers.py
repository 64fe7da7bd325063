# SPDX-License-Identifier: Apache-2.0
"""Handlers of commands for runs, drafts, campaigns and vehicles."""

import asyncio
from dataclasses import asdict

from aiohttp import web

from rocsafe_console.errors import ConsoleError
from rocsafe_console.people.roles import Action
from rocsafe_console.people.sessions import Session
from rocsafe_console.runs.jobs import KINDS, Jobs
from rocsafe_console.web.context import context_of, mission_session, session_of
from rocsafe_console.web.guards import REPORT_POLICY, body_of

JOBS: web.AppKey[Jobs] = web.AppKey('jobs', Jobs)


async def list_campaigns(request: web.Request) -> web.Response:
    """List the campaigns that can be flown."""
    session_of(request, Action.DRAFT)
    return web.json_response({'campaigns': request.app[JOBS].campaigns()})


async def campaign_page(request: web.Request) -> web.StreamResponse:
    """Send the page of a campaign."""
    session_of(request, Action.SEE)
    answer = web.FileResponse(request.app[JOBS].campaign_page(request.match_info['name']))
    answer.headers['Content-Security-Policy'] = REPORT_POLICY
    return answer


async def begin_job(request: web.Request) -> web.Response:
    """Start a command; it is written to the evidence log first."""
    kind, name, session = _job(request)
    await body_of(request)
    context, jobs = context_of(request), request.app[JOBS]
    # What is not there is refused before it is logged.
    KINDS[kind].words(jobs.folders, name)
    if KINDS[kind].action is Action.LAUNCH:
        context.require_launches()
    await context.write(kind, session.user, name if KINDS[kind].is_of_run else '', name=name)
    job = await asyncio.to_thread(jobs.begin, kind, name, session.user)
    return web.json_response(asdict(job))


async def look_at_job(request: web.Request) -> web.Response:
    """Tell how a command stands, and what it has printed."""
    kind, name, _ = _job(request)
    return web.json_response(asdict(request.app[JOBS].look(kind, name)))


async def end_job(request: web.Request) -> web.Response:
    """End a command; it is written to the evidence log first."""
    kind, name, session = _job(request)
    await context_of(request).write('end', session.user, name=f'{kind} {name}')
    request.app[JOBS].end(kind, name)
    return web.json_response({})


def _job(request: web.Request) -> tuple[str, str, Session]:
    """Return kind and name of a command, and the session of who may give it."""
    kind, name = request.match_info['kind'], request.match_info['name']
    if kind not in KINDS:
        raise ConsoleError(f'command {kind!r}: there is none')
    job = KINDS[kind]
    if job.is_of_run:
        return kind, name, mission_session(request, job.action, name)
    return kind, name, session_of(request, job.action)
