# SPDX-License-Identifier: Apache-2.0
"""The control lease of a vehicle: the right to command it. Time is an argument.

A lease only decides who may give orders. Its end never moves the vehicle: a flight under way
continues on its verified route. It is kept by steady time of the machine, because it says whether
its holder lives: simulated time may stand still, or pass a hundred times as fast.
"""

import hashlib
from dataclasses import dataclass, replace

# A supervisor sets this for all nodes of its mission, and knows them by it.
MISSION_VARIABLE = 'ROCSAFE_MISSION_TOKEN'
DEFAULT_S = 30.0
LONGEST_S = 3600.0
LONGEST_NAME = 128


class LeaseRefusedError(Exception):
    """A request for a lease, or an order, is refused; the text says who leads the vehicle."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lease:
    """The last lease that a vehicle granted. It survives its process.

    Attributes
    ----------
    server
        Identity of the node that granted it; two nodes of one vehicle's name differ in it.
    epoch
        Number of leases granted.
    holder, mission
        Who has it, and of which mission; an empty holder: nobody.
    duration_s
        Time from its grant, or last renewal, to its end, seconds.
    void
        Why it has no force although it has not ended; empty: it has.
    """

    server: str
    epoch: int = 0
    holder: str = ''
    mission: str = ''
    duration_s: float = DEFAULT_S
    void: str = ''

    @property
    def number(self) -> str:
        """The token that orders carry; empty without a holder of the lease."""
        return f'{self.server}/{self.epoch}' if self.holder else ''

    @property
    def who(self) -> str:
        """Holder and mission, for people."""
        return f'{self.holder}, mission {self.mission}' if self.mission else self.holder


def server_of(vehicle: str, token: str) -> str:
    """Return the identity of the node of a vehicle; the token cannot be learned from it."""
    return hashlib.sha256(f'{token}/{vehicle}'.encode()).hexdigest()[:12]


class LeaseKeeper:
    """Grants the lease of one vehicle, and judges orders by it.

    Parameters
    ----------
    vehicle
        Name of the vehicle, for texts.
    lease
        Lease of an earlier process, which has its full time again; or one without a holder.
    now_s
        Steady time, seconds, as in all methods.

    Attributes
    ----------
    text
        What changed last, for people.
    """

    def __init__(self, vehicle: str, lease: Lease, now_s: float) -> None:
        self.lease = lease
        self.expires_s = now_s + lease.duration_s
        self.text = ''
        self._vehicle = vehicle

    def is_valid(self, now_s: float) -> bool:
        """Return whether the lease has a holder."""
        return bool(self.lease.holder) and not self.lease.void and now_s < self.expires_s

    def take(self, asked: Lease, now_s: float, *, takes_over: bool = False) -> None:
        """Grant the lease to the holder of `asked`; its own holder keeps its number.

        Raises
        ------
        LeaseRefusedError
            If another holder has it, unless `takes_over`.
        ValueError
            If the name of the holder is empty, a name too long, or the time not within limits.
        """
        _require_names(asked)
        before, was_led = self.lease, self.is_valid(now_s)
        is_same = (asked.holder, asked.mission) == (before.holder, before.mission)
        if was_led and not is_same and not takes_over:
            raise LeaseRefusedError(f'{self._led(now_s)}; wait, or take it over')
        self._extend(asked.duration_s, now_s)
        if is_same and not before.void:
            return
        self.lease = replace(
            self.lease, epoch=before.epoch + 1, holder=asked.holder, mission=asked.mission, void=''
        )
        self.text = f'led by {self.lease.who}'
        if was_led:
            self.text += f', taken over from {before.who}'

    def renew(self, number: str, duration_s: float, now_s: float) -> None:
        """Extend the lease `number`, also after its end unless it was taken since.

        Raises
        ------
        LeaseRefusedError
            If it is not the last one, or void.
        ValueError
            If the time is not within limits.
        """
        self._require_last(number, now_s)
        self._extend(duration_s, now_s)

    def release(self, number: str, now_s: float) -> None:
        """End the lease `number`; raises `LeaseRefusedError` as `renew`."""
        self._require_last(number, now_s)
        self.text = f'given back by {self.lease.who}'
        self.lease = replace(self.lease, holder='', mission='')

    def revoke(self, why: str) -> None:
        """Make the lease void until it is taken again: another has the vehicle."""
        if self.lease.holder and not self.lease.void:
            self.lease = replace(self.lease, void=why)
            self.text = f'the lease of {self.lease.who} is void: {why}'

    def require(self, number: str, now_s: float) -> None:
        """Refuse an order that does not carry the lease; raises `LeaseRefusedError`."""
        self._require_last(number, now_s)
        if now_s >= self.expires_s:
            raise LeaseRefusedError(f'the lease of {self.lease.who} has ended: renew it')

    def _require_last(self, number: str, now_s: float) -> None:
        if number and number == self.lease.number and not self.lease.void:
            return
        raise LeaseRefusedError(f'{self._led(now_s)}; take the lease first')

    def _extend(self, duration_s: float, now_s: float) -> None:
        if not 0.0 <= duration_s <= LONGEST_S:
            raise ValueError(f'duration_s is {duration_s:g}: must be within 0 and {LONGEST_S:g} s')
        self.lease = replace(self.lease, duration_s=duration_s or DEFAULT_S)
        self.expires_s = now_s + self.lease.duration_s

    def _led(self, now_s: float) -> str:
        lease, name = self.lease, self._vehicle
        if lease.void:
            return f'the lease of {lease.who} is void: {lease.void}'
        if not self.is_valid(now_s):
            return f'nobody leads {name}'
        return f'{name} is led by {lease.who} for {self.expires_s - now_s:.0f} s more'


def _require_names(asked: Lease) -> None:
    if not asked.holder.strip():
        raise ValueError('holder is empty: must say who asks')
    for name, text in (('holder', asked.holder), ('mission', asked.mission)):
        if len(text) > LONGEST_NAME or not (text.isprintable()):
            raise ValueError(f'{name} must be printable, with up to {LONGEST_NAME} characters')
