# SPDX-License-Identifier: Apache-2.0
"""State machine of the presence of one vehicle: it takes orders, is silent, or is replaced."""

from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_geo.limits import require_positive

# A vehicle that was replaced so often gets no more work: its link or its process is not reliable.
MOST_RETURNS = 3


class Presence(Enum):
    """Presence of a vehicle in a mission."""

    PRESENT = 'present'
    SILENT = 'silent'
    LOST = 'lost'
    RETURNED = 'returned'
    APART = 'apart'


@dataclass(frozen=True, slots=True, kw_only=True)
class Lease:
    """Heartbeat lease of a vehicle.

    Attributes
    ----------
    silent_s
        Silence after which a vehicle gets no orders, seconds.
    lost_s
        Silence after which others take over, seconds; more than `silent_s`.
    """

    silent_s: float
    lost_s: float

    def __post_init__(self) -> None:
        require_positive('silent_s', self.silent_s, 's')
        if not self.lost_s > self.silent_s:
            raise ValueError(f'lost_s is {self.lost_s:g}: must be above silent_s')


@dataclass(frozen=True, slots=True, kw_only=True)
class Sighting:
    """What is known of a vehicle at one moment.

    Attributes
    ----------
    silent_s
        Time since it was heard, seconds.
    ending
        Why its present flight will not end as planned; empty: it will.
    taken_by
        Who has it in the air instead of this mission; empty: nobody.
    is_grounded
        Whether it is on the ground, or lies there.
    is_unheard
        Whether its own bridge has lost it.
    """

    silent_s: float = 0.0
    ending: str = ''
    taken_by: str = ''
    is_grounded: bool = False
    is_unheard: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A vehicle as a member of the fleet of a mission.

    Attributes
    ----------
    presence
        Whether it is there. PRESENT: it flies its route and takes orders. SILENT: it gets no
        orders. LOST: others are to take over. RETURNED: it was replaced, is heard again and
        holds until what it did is merged. APART: it flies without orders, because its flight
        ends early, or its pilot or a failsafe has it.
    is_replaced
        Whether others have taken over its work: it must not fly its old route.
    is_withdrawn
        Whether it gets no more work in this mission.
    returns
        How often it came back after it was replaced.
    why
        Why it is not present.
    """

    presence: Presence = Presence.PRESENT
    is_replaced: bool = False
    is_withdrawn: bool = False
    returns: int = 0
    why: str = ''

    @property
    def takes_orders(self) -> bool:
        """Whether it can be given a route."""
        return self.presence in (Presence.PRESENT, Presence.RETURNED)

    def seen(self, sighting: Sighting, lease: Lease) -> 'Member':
        """Return the member after one look at it."""
        if sighting.is_unheard or sighting.silent_s > lease.lost_s:
            return self._gone(f'nothing heard for {max(sighting.silent_s, lease.silent_s):.0f} s')
        if sighting.silent_s > lease.silent_s:
            return replace(self, presence=Presence.SILENT) if self.takes_orders else self
        if sighting.ending:
            return self._ended(sighting.ending)
        if sighting.taken_by:
            why = f'its {sighting.taken_by} has it'
            return replace(self, presence=Presence.APART, why=why)
        if self.is_withdrawn:
            return replace(self, presence=Presence.APART)
        if self.is_replaced:
            return self._back(is_grounded=sighting.is_grounded)
        return replace(self, presence=Presence.PRESENT, why='')

    def lost(self, why: str) -> 'Member':
        """Return the member after its loss was announced."""
        return replace(self, presence=Presence.LOST, why=why)

    def replaced(self) -> 'Member':
        """Return the member after others took over."""
        return replace(self, is_replaced=True)

    def merged(self) -> 'Member':
        """Return the member after what it did was merged, and new work was planned for it."""
        return replace(self, presence=Presence.PRESENT, is_replaced=False, why='')

    def withdrawn(self, why: str) -> 'Member':
        """Return the member that gets no more work."""
        return replace(self, presence=Presence.APART, is_replaced=True, is_withdrawn=True, why=why)

    def _gone(self, why: str) -> 'Member':
        """Return the member after a silence that is too long; an earlier reason stays."""
        is_news = self.presence is not Presence.LOST
        return self.lost(why) if is_news else self

    def _ended(self, why: str) -> 'Member':
        """Return the member after it announced an early end of its flight."""
        if self.is_replaced:
            return replace(self, presence=Presence.APART, why=self.why or why)
        return self if self.presence is Presence.LOST else self.lost(why)

    def _back(self, *, is_grounded: bool) -> 'Member':
        """Return a replaced member that reports again: it holds, or has landed for good."""
        if is_grounded:
            return replace(self, presence=Presence.APART, why=self.why or 'it has landed')
        if self.presence is Presence.RETURNED:
            return self
        if self.returns >= MOST_RETURNS:
            return self.withdrawn(f'it came back {self.returns} times')
        is_again = self.presence is not Presence.SILENT
        return replace(self, presence=Presence.RETURNED, returns=self.returns + is_again)
