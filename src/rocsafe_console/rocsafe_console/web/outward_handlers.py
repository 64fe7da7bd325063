# SPDX-License-Identifier: Apache-2.0
"""What other systems read: OGC API Features by a link."""

import json

from aiohttp import web

from rocsafe_console.errors import ConsoleError
from rocsafe_console.outward import features
from rocsafe_console.people.roles import Action
from rocsafe_console.web.context import context_of, limited, mission_session, session_of
from rocsafe_geo.storage.json_values import finite


async def make_link(request: web.Request) -> web.Response:
    """Make an address that QGIS opens: whoever has it sees, for as long as a session."""
    context, session = context_of(request), session_of(request, Action.SEE)
    limited(request, session)
    secret, link = context.sessions.begin(
        session.user, session.role, request.remote or '', context.clock(), is_link=True
    )
    await context.write('link', session.user, session=link.public_id)
    return web.json_response({'url': f'{context.options.scheme}://{request.host}/ogc/{secret}'})


async def landing(request: web.Request) -> web.Response:
    """Send the landing page."""
    return web.json_response(features.landing_of(_base(request)))


async def definition(request: web.Request) -> web.Response:
    """Send the definition of the interface."""
    body = json.dumps(features.definition_of(_base(request))).encode()
    return web.Response(body=body, headers={'Content-Type': features.OPENAPI})


async def conformance(request: web.Request) -> web.Response:
    """Send what is conformed to."""
    session_of(request, Action.SEE)
    return web.json_response({'conformsTo': list(features.CONFORMANCE)})


async def collections(request: web.Request) -> web.Response:
    """Send the collections."""
    return web.json_response(features.collections_of(_base(request)))


async def collection(request: web.Request) -> web.Response:
    """Send one collection."""
    name = _name(request)
    return web.json_response(features.collection_of(_base(request), name))


async def items(request: web.Request) -> web.Response:
    """Send the features of a collection as it is now."""
    context, base, name = context_of(request), _base(request), _name(request)
    mission_session(request, Action.SEE)
    with context.live.lock:
        picture, now_s = context.live.picture, context.clock()
        content = features.items_of(base, name, picture, now_s, request.query)
    return web.json_response(content, content_type=features.GEOJSON, dumps=_dumps)


async def item(request: web.Request) -> web.Response:
    """Send one feature of a collection as it is now."""
    context, base, name = context_of(request), _base(request), _name(request)
    mission_session(request, Action.SEE)
    number = int(request.match_info['number'])
    with context.live.lock:
        picture, now_s = context.live.picture, context.clock()
        try:
            content = features.item_of(base, name, picture, now_s, number)
        except KeyError as error:
            raise ConsoleError(str(error.args[0])) from error
    return web.json_response(content, content_type=features.GEOJSON, dumps=_dumps)


def _base(request: web.Request) -> str:
    session_of(request, Action.SEE)
    secret = request.match_info['secret']
    return f'{context_of(request).options.scheme}://{request.host}/ogc/{secret}'


def _name(request: web.Request) -> str:
    session_of(request, Action.SEE)
    name = request.match_info['name']
    if name not in features.COLLECTIONS:
        raise ConsoleError(f'collection {name!r}: there is none')
    return name


def _dumps(content: object) -> str:
    return json.dumps(finite(content), separators=(',', ':'), allow_nan=False)
