# SPDX-License-Identifier: Apache-2.0
"""Handlers of seals: whether a run is as it was sealed, and a new seal of it."""

import asyncio

from aiohttp import web

from rocsafe_console.errors import RefusedError
from rocsafe_console.evidence.seal import notes_of, seal_run, seals_of, signer_of, verify_run
from rocsafe_console.evidence.signing import usual_key
from rocsafe_console.people.roles import Action
from rocsafe_console.runs.run_folder import is_flying, run_in
from rocsafe_console.web.context import context_of, mission_session, session_of
from rocsafe_console.web.guards import body_of
from rocsafe_geo.evidence.code_version import version_text
from rocsafe_geo.evidence.evidence_log import EvidenceError

# Hashing a run keeps a disk busy: one at a time.
SEALING: web.AppKey[asyncio.Lock] = web.AppKey('sealing', asyncio.Lock)


async def verify(request: web.Request) -> web.Response:
    """Tell what has been changed in a run since it was sealed."""
    run = run_in(context_of(request).options.runs, request.match_info['run'])
    mission_session(request, Action.SEE, run.name)
    async with request.app[SEALING]:
        faults = await asyncio.to_thread(verify_run, run)
    seals = seals_of(run)
    newest = seals[-1].name if seals else ''
    answer = {'faults': faults[:100], 'seal': newest, 'signer': '', 'notes': []}
    if not faults:
        answer |= {'signer': signer_of(seals[-1]), 'notes': notes_of(run)}
    return web.json_response(answer)


async def seal(request: web.Request) -> web.Response:
    """Seal a run with the key of this machine's user, if there is one."""
    context = context_of(request)
    session_of(request, Action.SEAL)
    await body_of(request)
    run = run_in(context.options.runs, request.match_info['run'])
    session = mission_session(request, Action.SEAL, run.name)
    if is_flying(run):
        raise RefusedError(f'{run.name} has not ended: it is sealed at its end')
    await context.write('seal', session.user, run.name, mission=run.name)
    async with request.app[SEALING]:
        try:
            key = usual_key(context.environment)
            made = await asyncio.to_thread(
                seal_run, run, context.clock(), session.user, version_text(), key
            )
        except (EvidenceError, OSError) as error:
            raise RefusedError(str(error)) from error
    return web.json_response({'seal': made.name, 'signer': signer_of(made)})
