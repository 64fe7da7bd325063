# SPDX-License-Identifier: Apache-2.0
"""Orders in two steps: prepared, then confirmed once within some seconds. Time is an argument.

An order has the id that its sender gave it: what is sent twice is done once, and answered twice.
It names the revision of each vehicle that the operator saw. A vehicle that has moved on since is
left out, and said so; only a hold is always sent, for it makes no state more dangerous.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from rocsafe_console.errors import RefusedError
from rocsafe_console.people.roles import VERBS, Action

CONFIRM_S = 8.0
MOST_KEPT = 1000
LOWEST_M, HIGHEST_M = 5.0, 500.0
# A ground vehicle is spent before; a larger number is a mistake of the unit.
MOST_DOSE_USV = 1e6
_ID = re.compile(r'[A-Za-z0-9-]{16,64}')
NEVER_STALE = frozenset({Action.HOLD})


class Outcome(Enum):
    """What became of an order for one vehicle."""

    DONE = 'done'
    REFUSED = 'refused'
    SILENT = 'no answer'
    STALE = 'state has changed'


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Place to which a vehicle is sent: degrees, and metres above its home."""

    latitude_deg: float
    longitude_deg: float
    height_m: float

    def __post_init__(self) -> None:
        _require_on_earth(self.latitude_deg, self.longitude_deg)
        if not LOWEST_M <= self.height_m <= HIGHEST_M:
            raise ValueError(
                f'height_m = {self.height_m}: must be within {LOWEST_M:g} and {HIGHEST_M:g} m'
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Errand:
    """Place to which a ground vehicle drives, degrees, and dose that it may take on the way."""

    latitude_deg: float
    longitude_deg: float
    dose_budget_usv: float

    def __post_init__(self) -> None:
        _require_on_earth(self.latitude_deg, self.longitude_deg)
        if not 0.0 < self.dose_budget_usv <= MOST_DOSE_USV:
            raise ValueError(
                f'dose_budget_usv = {self.dose_budget_usv}: must be above 0 and at most '
                f'{MOST_DOSE_USV:g} uSv'
            )


TARGETS: Mapping[Action, type[Target] | type[Errand]] = {
    Action.GO_TO: Target, Action.SEND: Errand
}  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """What an operator wants of vehicles.

    Attributes
    ----------
    request_id
        16 to 64 letters, digits and ``-``, of which the sender makes a new one for each order.
    session
        Public id of the session: nobody else confirms it.
    revisions
        Of each vehicle ordered, as the operator saw it.
    """

    request_id: str
    session: str
    user: str
    verb: Action
    revisions: Mapping[str, int]
    target: Target | Errand | None = None

    def __post_init__(self) -> None:
        if not _ID.fullmatch(self.request_id):
            raise ValueError('request_id must be 16 to 64 letters, digits and "-"')
        if self.verb not in VERBS:
            raise ValueError(f'verb {self.verb.value!r} is no order to a vehicle')
        if not self.revisions:
            raise ValueError('vehicles: must be one or more')
        wanted = TARGETS.get(self.verb)
        if type(self.target) is not (wanted or type(None)):
            raise ValueError('target: go_to and send need one of their own, nothing else has one')
        if wanted is not None and len(self.revisions) > 1:
            raise ValueError(f'{self.verb.value}: must be for one vehicle: two would meet')


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """What became of an order for one vehicle, with the reason."""

    vehicle: str
    outcome: Outcome
    text: str = ''


@dataclass(slots=True)
class _Entry:
    order: Order
    until_s: float
    is_confirmed: bool = False
    results: tuple[Result, ...] | None = None


@dataclass(slots=True)
class OrderBook:
    """Orders that were prepared, and what became of them."""

    _entries: dict[str, _Entry] = field(default_factory=dict)

    def prepare(self, order: Order, now_s: float) -> float:
        """Keep an order until it is confirmed; return until when, seconds.

        Raises
        ------
        RefusedError
            If there is another order of this id.
        """
        entry = self._entries.get(order.request_id)
        if entry is not None and entry.order != order:
            raise RefusedError(f'order {order.request_id}: there is another one of this id')
        if entry is None:
            entry = self._entries[order.request_id] = _Entry(order, now_s + CONFIRM_S)
            while len(self._entries) > MOST_KEPT:
                del self._entries[next(iter(self._entries))]
        return entry.until_s

    def confirm(self, request_id: str, session: str, now_s: float) -> Order | None:
        """Return the order to send; None if it has been confirmed before.

        Raises
        ------
        RefusedError
            If there is none of this id and session, or its time is over.
        """
        entry = self._entries.get(request_id)
        if entry is None or entry.order.session != session:
            raise RefusedError(f'order {request_id}: none is waiting for you to confirm it')
        if entry.is_confirmed:
            return None
        if now_s > entry.until_s:
            raise RefusedError(f'not confirmed within {CONFIRM_S:g} s: nothing was sent')
        entry.is_confirmed = True
        return entry.order

    def finish(self, request_id: str, results: tuple[Result, ...]) -> None:
        """Keep what became of an order, unless a thousand others have come since."""
        if entry := self._entries.get(request_id):
            entry.results = results

    def results(self, request_id: str) -> tuple[Result, ...] | None:
        """Return what became of an order, None if that is not known yet."""
        entry = self._entries.get(request_id)
        return entry.results if entry is not None else None


def stale(order: Order, revisions: Mapping[str, int]) -> tuple[Result, ...]:
    """Return the vehicles of an order that are not as its sender saw them.

    Parameters
    ----------
    revisions
        Of each vehicle, now.
    """
    if order.verb in NEVER_STALE:
        return ()
    changed = tuple(
        Result(
            vehicle=name,
            outcome=Outcome.STALE,
            text=f'{name} has changed since you looked: look again',
        )
        for name, seen in order.revisions.items()
        if revisions.get(name) != seen
    )
    if order.verb is Action.REPLAN and changed:
        # One plan for all: what was seen of one vehicle was seen of the fleet.
        text = f'not planned anew: {changed[0].text}'
        return tuple(
            Result(vehicle=name, outcome=Outcome.STALE, text=text) for name in order.revisions
        )
    return changed


def _require_on_earth(latitude_deg: float, longitude_deg: float) -> None:
    if not (-90.0 <= latitude_deg <= 90.0 and -180.0 <= longitude_deg <= 180.0):
        raise ValueError(f'target {latitude_deg}, {longitude_deg}: must be on the earth')
