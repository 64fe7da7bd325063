# SPDX-License-Identifier: Apache-2.0
"""A request to a node, repeated until it is answered: its server may restart at any time."""

from dataclasses import dataclass
from enum import Enum


class OrderKind(Enum):
    """Kinds of orders that the mission sends."""

    PLAN = 'plan the survey'
    FLY = 'fly the route'
    ADVISE = 'say where to measure next'
    HOLD = 'hold'
    RESUME = 'go on after the hold'
    RETURN = 'return home'
    RETREAT = 'return by the way of least dose'
    DISMISS = 'wait for it no more'
    PAUSE_CLOCK = 'pause simulated time'
    RUN_CLOCK = 'start simulated time'
    SAVE_MOSAIC = 'write the mosaic'
    ASSESS = 'assess all readings'
    PLAN_DRIVE = 'plan the drive'
    DRIVE = 'drive the route'
    WRITE_PRODUCTS = 'write the products'


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """One thing to ask for; `vehicle` is named where the order is for one."""

    kind: OrderKind
    vehicle: str = ''


class Status(Enum):
    """State of a request."""

    WAITING = 'waiting'
    ACCEPTED = 'accepted'
    DONE = 'done'


class Request:
    """One order and its state.

    Parameters
    ----------
    order
        The order to send.
    server
        Name of the process that answers it.
    repeat_s
        An order that is not accepted is sent again after this time, then after twice that.
    """

    def __init__(self, order: Order, server: str, repeat_s: float) -> None:
        self.order = order
        self.server = server
        self.status = Status.WAITING
        self._first_pause_s = repeat_s
        self.reset()

    def reset(self) -> None:
        """Send again, for instance because the server was restarted; an answered request stays."""
        if self.status is Status.DONE:
            return
        self.status = Status.WAITING
        self._first_sent_s: float | None = None
        self._next_s: float | None = None
        self._pause_s = self._first_pause_s

    def is_due(self, now_s: float) -> bool:
        """Return whether the order is to be sent now; if so the next time is set."""
        is_early = self._next_s is not None and now_s < self._next_s
        if self.status is not Status.WAITING or is_early:
            return False
        if self._first_sent_s is None:
            self._first_sent_s = now_s
        self._next_s = now_s + self._pause_s
        self._pause_s *= 2.0
        return True

    def waited_s(self, now_s: float) -> float:
        """Return for how long nobody has accepted the order."""
        if self.status is not Status.WAITING or self._first_sent_s is None:
            return 0.0
        return now_s - self._first_sent_s

    def accept(self) -> bool:
        """Note that the server has taken the order; return whether that was still open."""
        was_open = self.status is Status.WAITING
        if was_open:
            self.status = Status.ACCEPTED
        return was_open

    def finish(self) -> None:
        """Note the answer."""
        self.status = Status.DONE
