# SPDX-License-Identifier: Apache-2.0
"""A link: addresses of peers, each with its own reader, and what is sent to each.

No input or output: a transport hands in the bytes of an address and takes those to send.
"""

from collections.abc import Hashable
from dataclasses import dataclass

from rocsafe_mavlink.link.link_limits import LINK_LIMITS
from rocsafe_mavlink.link.peer import Peer
from rocsafe_mavlink.wire.authority import Authority
from rocsafe_mavlink.wire.counters import Counters, Reason
from rocsafe_mavlink.wire.dialect import Message, encode
from rocsafe_mavlink.wire.framing import pack_frame
from rocsafe_mavlink.wire.signing import SignatureGate, Signer

Address = Hashable


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkIdentity:
    """Our own MAVLink numbers: a ground station with a system number of its own."""

    system: int = 255
    component: int = 190

    def __post_init__(self) -> None:
        for name, value in (('system', self.system), ('component', self.component)):
            if not 1 <= value <= 255:
                raise ValueError(f'{name} = {value} must be within 1 and 255')


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkRules:
    """Addresses that a link hears.

    Attributes
    ----------
    allowed
        Addresses that are heard from the start.
    called
        Those of them that get heartbeats before they were heard: we call, they answer.
    is_discovering
        Whether any other address may become a peer without a signature.
    is_stream
        Whether the bytes come without message borders.
    """

    allowed: frozenset[Address] = frozenset()
    called: frozenset[Address] = frozenset()
    is_discovering: bool = False
    is_stream: bool = False


class Link:
    """Reads and writes MAVLink for any number of peers.

    An address that is not allowed becomes a peer by a message with a good signature, or while
    discovering by any plausible one. Being a peer gives no right to speak for a vehicle, see
    `may_take_over`. Of too many peers the one that was heard longest ago is forgotten, never one
    in `held`: strangers cannot use up the table.

    Parameters
    ----------
    rules
        Addresses to hear.
    identity
        Our own MAVLink numbers.
    gate, signer
        Check and make signatures; both or none.

    Attributes
    ----------
    held
        Addresses from which vehicles speak.
    """

    def __init__(
        self,
        rules: LinkRules,
        identity: LinkIdentity | None = None,
        gate: SignatureGate | None = None,
        signer: Signer | None = None,
    ) -> None:
        if (gate is None) != (signer is None):
            raise ValueError('a link reads and writes signatures, or neither')
        self.counters = Counters()
        self.held: frozenset[Address] = frozenset()
        self._rules = rules
        self._identity = LinkIdentity() if identity is None else identity
        self._gate = gate
        self._signer = signer
        self._authority = Authority()
        self._peers: dict[Address, Peer] = {}
        self._stranger = self._new_peer(is_stream=False)
        self._sequence = 0
        self._late: dict[Address, float] = {}

    @property
    def peers(self) -> tuple[Address, ...]:
        """Addresses that were heard with a good message, the last heard at the end."""
        return tuple(self._peers)

    @property
    def stations(self) -> tuple[Address, ...]:
        """Addresses that get our heartbeats: of vehicles, and those that we call.

        No other address gets them: a foreign vehicle would take them for those of its own station.
        A holder of the key whose clock is behind gets them, too, until it follows ours: a vehicle
        without GPS time sets its clock by the first signed message that it gets.
        """
        return tuple(dict.fromkeys((*self._rules.called, *self.held, *self._late)))

    @property
    def is_signed(self) -> bool:
        """Whether only holders of the key are heard."""
        return self._gate is not None

    @property
    def fault(self) -> str:
        """Fault of the link that its user has to repair; empty: none."""
        return '' if self._signer is None else self._signer.fault

    def may_take_over(self, present: Address, other: Address) -> bool:
        """Return whether `other` may speak for a vehicle that spoke from `present` before.

        By its signature, since it is allowed by name, or as another port of the same host: a
        vehicle behind a router or one whose simulator was started again.
        """
        return self.is_signed or other in self._rules.allowed or _host(present) == _host(other)

    def receive(self, address: Address, data: bytes, now_s: float, time_s: float) -> list[Message]:
        """Return the plausible messages in `data` from `address`.

        Parameters
        ----------
        now_s
            Steady time, seconds.
        time_s
            Time of day, seconds since 1970.
        """
        peer = self._peers.get(address)
        if peer is None and address not in self._rules.allowed:
            return self._hear_stranger(address, data, now_s, time_s)
        if peer is None:
            peer = self._join(address)
        messages = peer.receive(data, now_s, time_s)
        self._note_late(address, now_s, is_late=peer.is_late)
        if messages:
            self._peers[address] = self._peers.pop(address)
        return messages

    def pack(self, message: Message, now_s: float, time_s: float) -> bytes:
        """Return the frame of `message`, signed if the link has a key.

        Raises
        ------
        NotAllowedError
            If it may not be sent.
        ValueError
            If a value does not fit into its field.
        """
        self._authority.require(message, now_s)
        number, payload = encode(message)
        us = self._identity
        frame = pack_frame(
            number, payload, us.system, us.component, self._sequence, sign=self._signer is not None
        )
        self._sequence = (self._sequence + 1) % 256
        self.counters.sent += 1
        return frame if self._signer is None else frame + self._signer.signature(frame, time_s)

    def _hear_stranger(
        self, address: Address, data: bytes, now_s: float, time_s: float
    ) -> list[Message]:
        may_join = self._gate is not None or self._rules.is_discovering
        if not may_join:
            self.counters.drop(Reason.UNKNOWN_PEER)
            return []
        messages = self._stranger.receive(data, now_s, time_s)
        self._note_late(address, now_s, is_late=self._stranger.is_late)
        # A radio modem sends its own unsigned status; it does not make its address a peer.
        heard = [message for message in messages if message.name != 'RADIO_STATUS']
        if heard:
            self._join(address)
        return heard

    def _note_late(self, address: Address, now_s: float, *, is_late: bool) -> None:
        """Note who holds the key and is behind in time, for some seconds."""
        if is_late and (address in self._late or len(self._late) < LINK_LIMITS.late_holders):
            self._late[address] = now_s
        if self._late:
            kept = {one: s for one, s in self._late.items() if now_s - s < LINK_LIMITS.late_for_s}
            self._late = kept

    def _join(self, address: Address) -> Peer:
        """Return a new peer; of too many the one that was heard longest ago is forgotten."""
        others = [known for known in self._peers if known not in self.held]
        if len(others) >= LINK_LIMITS.peers:
            del self._peers[others[0]]
        peer = self._peers[address] = self._new_peer(is_stream=self._rules.is_stream)
        return peer

    def _new_peer(self, *, is_stream: bool) -> Peer:
        return Peer(self.counters, self._gate, is_stream=is_stream)


def _host(address: Address) -> Hashable:
    """Return the host of an IP address; a device is its own."""
    return address[0] if isinstance(address, tuple) else address
