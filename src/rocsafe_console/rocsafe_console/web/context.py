# SPDX-License-Identifier: Apache-2.0
"""What the handlers of requests work with."""

import asyncio
import contextlib
import math
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from aiohttp import web

from rocsafe_console.errors import RefusedError, TooManyError
from rocsafe_console.evidence.desk import Desk
from rocsafe_console.orders.order_book import Order, OrderBook, Result
from rocsafe_console.outward.event_target import EventTarget
from rocsafe_console.people.missions import Missions
from rocsafe_console.people.roles import Action, Role, require
from rocsafe_console.people.session_file import save_sessions
from rocsafe_console.people.sessions import AttemptLimit, RefusalCount, Session, Sessions
from rocsafe_console.people.users import Users
from rocsafe_console.picture.alarms import WARN
from rocsafe_console.picture.live import Live
from rocsafe_console.runs.base_map import BaseMap
from rocsafe_console.runs.drafts import MISSION_VARIABLE
from rocsafe_geo.evidence.evidence_log import Event

# Orders, marks and links of one session; a person cannot click faster.
ORDERS, ORDERS_S = 30, 10.0
# Lines of the evidence log for what one user was refused: no client fills the disk with them.
REFUSALS, REFUSALS_S = 10, 60.0
# For a line of the evidence log, before somebody in an emergency does not wait for it.
LOG_S = 1.0
MOST_PATH = 200


class Fleet(Protocol):
    """Sends orders to vehicles."""

    def send_order(
        self,
        order: Order,
        names: tuple[str, ...],
        finish: Callable[[tuple[Result, ...]], None],
    ) -> None:
        """Send an order to `names`; `finish` gets a result of each, from any thread."""

    def plan_drive(
        self, order: Order, finish: Callable[[dict[str, Any] | None, str], None]
    ) -> None:
        """Plan the drive of an order; `finish` gets it, or None and why not, from any thread."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WebOptions:
    """How the page is served.

    Attributes
    ----------
    host, port
        Address to listen at.
    certificate, key
        Files of TLS; None: not encrypted, loopback only.
    names
        Further host names under which the page is reached.
    runs
        Folder of the runs.
    scenarios
        Folder of scenarios to begin a new mission with.
    cursor_on_target
        Who gets events; None: nobody.
    token
        Opens a session of `token_user` without users; empty: users log in.
    """

    host: str = '127.0.0.1'
    port: int = 8600
    certificate: Path | None = None
    key: Path | None = None
    names: tuple[str, ...] = ()
    runs: Path = Path('runs')
    scenarios: Path = Path('config/scenarios')
    cursor_on_target: EventTarget | None = None
    token: str = ''
    token_user: str = ''

    @property
    def scheme(self) -> str:
        """Scheme of the address."""
        return 'https' if self.certificate else 'http'

    @property
    def cookie(self) -> str:
        """Name of the cookie of a session."""
        return '__Host-rocsafe' if self.certificate else f'rocsafe-{self.port}'


@dataclass(slots=True, kw_only=True)
class Context:
    """Parts of the server.

    Attributes
    ----------
    clock
        Returns the time on the wall, seconds since 1970.
    base_map
        Tiles that the operator has brought; None: none.
    environment
        Of the commands that are run for the page.
    fleet
        None until ROS has started.
    log_thread
        Writes the evidence logs, one event after the other.
    """

    options: WebOptions
    live: Live
    desk: Desk
    users: Users
    missions: Missions
    clock: Callable[[], float]
    base_map: BaseMap | None = None
    environment: Mapping[str, str] = field(default_factory=dict)
    fleet: Fleet | None = None
    log_thread: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(1, 'log'))
    sessions: Sessions = field(default_factory=Sessions)
    orders: OrderBook = field(default_factory=OrderBook)
    logins: AttemptLimit = field(default_factory=AttemptLimit)
    refusals: RefusalCount = field(default_factory=lambda: RefusalCount(REFUSALS, REFUSALS_S))
    order_rate: AttemptLimit = field(default_factory=lambda: AttemptLimit(ORDERS, ORDERS_S))

    def require_launches(self) -> None:
        """Raise `RefusedError` if a mission that is launched here would not be heard.

        A mission's own page hears that mission alone, also when it has ended.
        """
        if MISSION_VARIABLE in self.environment:
            raise RefusedError(
                'this page belongs to one mission and hears no other: start rocsafe console'
            )

    def end_former(self) -> None:
        """End the sessions of users whom `rocsafe users` has removed or changed."""
        former = self.users.changed()
        for session in self.sessions.all(self.clock()):
            if session.user in former:
                self.sessions.end(session.public_id)
        if former:
            self.save_sessions()

    def save_sessions(self) -> None:
        """Keep the sessions for the next process; what hinders it costs a log-in, no more."""
        with contextlib.suppress(OSError):
            save_sessions(self.options.runs, self.sessions)

    async def write(self, kind: str, by: str, run: str = '', /, **what: object) -> None:
        """Write to the evidence log of a run, or the running mission: on disk on return.

        A slow disk holds up neither the picture nor other requests.
        """
        event = Event(time_s=self.clock(), kind=kind, by=by, what=what)
        loop = asyncio.get_running_loop()
        damage = await loop.run_in_executor(self.log_thread, self.desk.write, event, run)
        if damage:
            with self.live.lock:
                self.live.picture.alarm(event.time_s, WARN, '', f'evidence log damaged: {damage}')

    async def note(self, kind: str, by: str, /, **what: object) -> str:
        """Write to the evidence log what no full or slow disk may hold up.

        Returns
        -------
        str
            Why it is not on disk; empty: it is. A line that is late comes when it comes.
        """
        writing = asyncio.ensure_future(self.write(kind, by, **what))
        try:
            await asyncio.wait_for(asyncio.shield(writing), LOG_S)
        except asyncio.TimeoutError:
            writing.add_done_callback(_forgotten)
            return f'not on disk within {LOG_S:g} s'
        except OSError as error:
            return str(error)
        return ''

    async def note_refusal(self, session: Session, path: str, why: str, asked: object) -> None:
        """Write to the evidence log that somebody was refused, as often as a person can ask.

        The line after others that were left out has their number.
        """
        left_out = self.refusals.note(session.user, self.clock())
        if left_out is not None:
            what = {'outcome': 'refused', 'path': path[:MOST_PATH], 'why': why, 'asked': asked}
            await self.note('refused', session.user, **what, refused_before=left_out)

    @property
    def mission(self) -> str:
        """Name of the mission that is heard, empty before there is one."""
        mission = self.live.picture.mission
        return mission.mission_id if mission else ''


def _forgotten(writing: asyncio.Future[None]) -> None:
    """Take the error of a line that nobody waits for any more."""
    if not writing.cancelled():
        writing.exception()


CONTEXT: web.AppKey[Context] = web.AppKey('context', Context)
SESSION: web.RequestKey[Session] = web.RequestKey('session', Session)
# What a request asks for, as far as its body has been read: for the line of its refusal.
ASKED: web.RequestKey[dict[str, Any]] = web.RequestKey('asked', dict)


def context_of(request: web.Request) -> Context:
    """Return the parts of the server."""
    return request.app[CONTEXT]


def session_of(request: web.Request, action: Action) -> Session:
    """Return the session of a request whose user may do `action`; raises `RefusedError`."""
    session = request[SESSION]
    require(session.role, action)
    return session


def limited(request: web.Request, session: Session) -> None:
    """Count a request of a session; raises `TooManyError` if no person can be so fast."""
    context = context_of(request)
    now_s = context.clock()
    if wait_s := context.order_rate.wait_s(session.public_id, now_s):
        raise TooManyError(f'too many requests: wait {math.ceil(wait_s)} s')
    context.order_rate.note(session.public_id, now_s)


def mission_session(request: web.Request, action: Action, run: str = '') -> Session:
    """Return the session of a request whose user may do `action` to a mission.

    Parameters
    ----------
    run
        The mission; empty: the one that is heard.

    Raises
    ------
    RefusedError
        By the role of the user, or by the rights on the mission.
    """
    session, context = session_of(request, action), context_of(request)
    access = context.missions.of(run or context.mission)
    access.require(session.user, session.role, action)
    return session


def local_session(context: Context, address: str) -> tuple[str, Session]:
    """Begin the session of whoever has the token: a commander on this machine."""
    return context.sessions.begin(
        context.options.token_user, Role.COMMANDER, address, context.clock()
    )
