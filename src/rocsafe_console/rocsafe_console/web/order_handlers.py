# SPDX-License-Identifier: Apache-2.0
"""Handlers of orders: prepared by a first request, confirmed and sent by a second."""

import asyncio
from collections.abc import Callable
from dataclasses import asdict
from typing import Any, TypeVar

from aiohttp import web

from rocsafe_console.errors import RefusedError
from rocsafe_console.orders.order_book import TARGETS, Order, Outcome, Result, stale
from rocsafe_console.people.missions import SAFE
from rocsafe_console.people.roles import Action
from rocsafe_console.web.context import (
    ASKED,
    Context,
    context_of,
    limited,
    mission_session,
    session_of,
)
from rocsafe_console.web.guards import body_of

ORDER_S = 7.0
# Of a search for a way; large maps take some seconds.
DRIVE_PLAN_S = 20.0
DATUM = 'WGS84, height above home'
NO_ROS = 'ROS has not started yet'
Found = TypeVar('Found')
Planned = tuple[dict[str, Any] | None, str]


async def prepare_order(request: web.Request) -> web.Response:
    """First step of an order: it waits for its confirmation."""
    context, body = context_of(request), await body_of(request)
    verb = Action(body['verb'])
    request[ASKED] = {'verb': verb.value, 'vehicles': _known(context, body.get('revisions'))}
    session = mission_session(request, verb)
    limited(request, session)
    target, kind = body.get('target'), TARGETS.get(verb)
    if target and kind is None:
        raise ValueError(f'target: {verb.value} has none')
    order = Order(
        request_id=str(body['request_id']),
        session=session.public_id,
        user=session.user,
        verb=verb,
        revisions={str(name): int(seen) for name, seen in dict(body['revisions']).items()},
        target=kind(**{key: float(target[key]) for key in target}) if kind and target else None,
    )
    with context.live.lock:
        unknown = sorted(order.revisions.keys() - context.live.picture.vehicles.keys())
    if unknown:
        raise ValueError(f'vehicle {unknown[0]}: there is none')
    answer: dict[str, Any] = {}
    if verb is Action.SEND:
        answer['drive'] = await _planned_drive(context, order)
    # What is offered can be confirmed from now on, however long it took to plan.
    answer['until_s'] = context.orders.prepare(order, context.clock())
    return web.json_response(answer, status=201)


async def confirm_order(request: web.Request) -> web.Response:
    """Second step of an order: it is written to the evidence log, and sent.

    Only hold, return and land are sent without their line, too: a full disk holds up no emergency.
    """
    context = context_of(request)
    session = session_of(request, Action.SEE)
    request_id = request.match_info['id']
    order = context.orders.confirm(request_id, session.public_id, context.clock())
    if order is None:
        return await _results(context, request_id)
    mission_session(request, order.verb)
    left_out, names = _addressees(context, order)
    plain_order = _order_plain(order, names)
    unlogged = await _write_down(context, order, 'order', plain_order)
    if unlogged and order.verb not in SAFE:
        text = f'nothing was sent: the evidence log cannot be written: {unlogged}'
        context.orders.finish(request_id, (*left_out, *_all(names, Outcome.REFUSED, text)))
        raise RefusedError(text)
    # The disk may have taken long.
    left_out, names = _addressees(context, order)
    results = (*left_out, *(await _sent(context, order, names) if names else ()))
    plain = [_result_plain(result) for result in results]
    context.orders.finish(request_id, results)
    outcomes = {result.vehicle: result.outcome.value for result in results}
    with context.live.lock:
        context.live.picture.on_order(order.user, order.verb.value, outcomes)
    # The vehicles have done it: that is told, whatever the disk does.
    outcome = {'request_id': request_id, 'results': plain}
    unlogged_outcome = await _write_down(
        context, order, 'outcome', {**outcome, 'order': plain_order} if unlogged else outcome
    )
    answer: dict[str, Any] = {'results': plain}
    if unlogged_outcome:
        answer['unlogged'] = unlogged_outcome
    return web.json_response(answer)


def _known(context: Context, wanted: object) -> list[str]:
    """Return the vehicles of this mission among the keys of what somebody sends."""
    with context.live.lock:
        names = context.live.picture.vehicles.keys()
    return sorted(names & wanted.keys()) if isinstance(wanted, dict) else []


async def _write_down(context: Context, order: Order, kind: str, what: dict[str, Any]) -> str:
    """Write to the evidence log; return why that was not possible, empty if it was.

    An order that makes nothing more dangerous, and any outcome, waits for no slow disk: the line
    comes when it comes.
    """
    if order.verb in SAFE or kind == 'outcome':
        return await context.note(kind, order.user, **what)
    try:
        await context.write(kind, order.user, **what)
    except OSError as error:
        return str(error)
    return ''


def _addressees(context: Context, order: Order) -> tuple[tuple[Result, ...], tuple[str, ...]]:
    """Return the vehicles that have moved on since they were seen, and those that are left."""
    with context.live.lock:
        revisions = {name: v.revision for name, v in context.live.picture.vehicles.items()}
    left_out = stale(order, revisions)
    return left_out, tuple(order.revisions.keys() - {result.vehicle for result in left_out})


async def _sent(context: Context, order: Order, names: tuple[str, ...]) -> tuple[Result, ...]:
    """Send an order and return the results of all vehicles."""
    fleet = context.fleet
    if fleet is None:
        return _all(names, Outcome.REFUSED, NO_ROS)
    try:
        return await _answer_of(lambda finish: fleet.send_order(order, names, finish), ORDER_S)
    except asyncio.TimeoutError:
        return _all(names, Outcome.SILENT, f'no answer within {ORDER_S:g} s')


def _all(names: tuple[str, ...], outcome: Outcome, text: str) -> tuple[Result, ...]:
    return tuple(Result(vehicle=name, outcome=outcome, text=text) for name in sorted(names))


async def _planned_drive(context: Context, order: Order) -> dict[str, Any]:
    """Return the drive that is offered for an order; `RefusedError` if there is no way."""
    fleet = context.fleet
    if fleet is None:
        raise RefusedError(NO_ROS)

    def ask(settle: Callable[[Planned], None]) -> None:
        fleet.plan_drive(order, lambda drive, why: settle((drive, why)))

    try:
        drive, why = await _answer_of(ask, DRIVE_PLAN_S)
    except asyncio.TimeoutError as error:
        raise RefusedError(f'no way was found within {DRIVE_PLAN_S:g} s') from error
    if drive is None:
        raise RefusedError(why)
    return drive


async def _answer_of(ask: Callable[[Callable[[Found], None]], None], limit_s: float) -> Found:
    """Return what `ask` is told by another thread, once."""
    loop = asyncio.get_running_loop()
    future: asyncio.Future[Found] = loop.create_future()

    def settle(found: Found) -> None:
        if not future.done():
            future.set_result(found)

    def on_answer(found: Found) -> None:
        loop.call_soon_threadsafe(settle, found)

    ask(on_answer)
    return await asyncio.wait_for(future, limit_s)


async def _results(context: Context, request_id: str) -> web.Response:
    """Return the results of an order that was confirmed before."""
    results = context.orders.results(request_id)
    if results is None:
        return web.json_response({'results': None}, status=202)
    return web.json_response({'results': [_result_plain(result) for result in results]})


def _order_plain(order: Order, names: tuple[str, ...]) -> dict[str, Any]:
    target = {**asdict(order.target), 'datum': DATUM} if order.target else None
    return {
        'request_id': order.request_id,
        'verb': order.verb.value,
        'vehicles': sorted(names),
        'revisions': dict(order.revisions),
        'target': target,
    }


def _result_plain(result: Result) -> dict[str, str]:
    return {'vehicle': result.vehicle, 'outcome': result.outcome.value, 'text': result.text}
