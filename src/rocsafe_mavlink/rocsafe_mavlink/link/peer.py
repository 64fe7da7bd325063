# SPDX-License-Identifier: Apache-2.0
"""One sender on a link: bytes in, plausible messages out.

The order of checks: size, frame and checksum, signature, rate, use, plausibility. Nothing that a
frame says is stored before its signature was found good.
"""

from rocsafe_mavlink.link.link_limits import LINK_LIMITS
from rocsafe_mavlink.wire.counters import Counters, Reason
from rocsafe_mavlink.wire.dialect import Message, decode
from rocsafe_mavlink.wire.framing import LARGEST_FRAME, MavlinkFrame, scan
from rocsafe_mavlink.wire.plausibility import fault_of, is_read
from rocsafe_mavlink.wire.rate_limit import RateLimit
from rocsafe_mavlink.wire.signing import SignatureGate, SignatureVerdict

# RADIO_STATUS, which a radio modem inserts; it has no key.
UNSIGNED_ALLOWED = frozenset({109})
_REASONS = {
    SignatureVerdict.FORGED: Reason.FORGED,
    SignatureVerdict.REPLAYED: Reason.REPLAYED,
    SignatureVerdict.TOO_OLD: Reason.TOO_OLD,
    SignatureVerdict.TOO_MANY_STREAMS: Reason.TOO_MANY_STREAMS,
}


class Peer:
    """Reads what one address sends.

    Parameters
    ----------
    counters
        Counters of the link.
    gate
        Checks signatures; None reads everything, signed or not.
    is_stream
        Whether the bytes come without message borders (TCP, serial), not in datagrams.

    Attributes
    ----------
    is_late
        Whether the last bytes held a message with a right signature by a clock that is behind.
    """

    def __init__(
        self, counters: Counters, gate: SignatureGate | None = None, *, is_stream: bool = False
    ) -> None:
        self._counters = counters
        self._gate = gate
        self._is_stream = is_stream
        self._rest = b''
        self._rate = RateLimit(LINK_LIMITS.messages_per_s)
        self._sequences: dict[tuple[int, int], int] = {}
        self.is_late = False

    @property
    def buffered(self) -> int:
        """Number of bytes kept of a frame that has not arrived whole."""
        return len(self._rest)

    def receive(self, data: bytes, now_s: float, time_s: float) -> list[Message]:
        """Return the plausible messages in `data`.

        Parameters
        ----------
        data
            A datagram, or the next bytes of a stream.
        now_s
            Steady time, seconds.
        time_s
            Time of day, seconds since 1970, for signatures.
        """
        messages = []
        self.is_late = False
        for frame in self._frames(data):
            if not self._is_genuine(frame, time_s):
                continue
            if not self._rate.take(now_s):
                self._counters.drop(Reason.RATE)
                continue
            self._count_lost(frame)
            message = self._believable(frame)
            if message is not None:
                messages.append(message)
        self._counters.received += len(messages)
        return messages

    def _frames(self, data: bytes) -> list[MavlinkFrame]:
        if not self._is_stream and len(data) > LINK_LIMITS.datagram_bytes:
            self._counters.drop(Reason.OVERSIZE)
            return []
        found = scan(self._rest + data, is_whole=not self._is_stream)
        if self._is_stream:
            # At most one incomplete frame is kept, whatever was sent.
            self._rest = (self._rest + data)[found.used :][-LARGEST_FRAME:]
        elif not found.frames:
            self._counters.drop(Reason.NO_FRAME)
        if found.false_starts:
            self._counters.drop(Reason.FALSE_START, found.false_starts)
        return found.frames

    def _is_genuine(self, frame: MavlinkFrame, time_s: float) -> bool:
        if self._gate is None:
            return True
        if not frame.is_signed:
            if frame.message_id in UNSIGNED_ALLOWED:
                return True
            self._counters.drop(Reason.UNSIGNED)
            return False
        verdict = self._gate.judge(frame, time_s)
        if verdict is not SignatureVerdict.GOOD:
            self._counters.drop(_REASONS[verdict])
        self.is_late |= verdict in (SignatureVerdict.TOO_OLD, SignatureVerdict.REPLAYED)
        return verdict is SignatureVerdict.GOOD

    def _count_lost(self, frame: MavlinkFrame) -> None:
        sender = (frame.system, frame.component)
        last = self._sequences.get(sender)
        if last is None and len(self._sequences) >= LINK_LIMITS.senders:
            return
        self._sequences[sender] = frame.sequence
        gap = 0 if last is None else (frame.sequence - last - 1) % 256
        if gap < LINK_LIMITS.sequence_gap:
            self._counters.lost += gap

    def _believable(self, frame: MavlinkFrame) -> Message | None:
        message = decode(frame.message_id, frame.payload, frame.system, frame.component)
        if not is_read(message.name):
            self._counters.drop(Reason.UNUSED)
            return None
        if fault_of(message):
            self._counters.drop(Reason.IMPLAUSIBLE)
            return None
        return message
