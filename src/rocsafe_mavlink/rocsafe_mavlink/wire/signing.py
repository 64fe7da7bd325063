# SPDX-License-Identifier: Apache-2.0
"""Message signatures: check the sender and refuse replays.

See https://mavlink.io/en/guide/message_signing.html. A signature is compared, in constant time,
before anything that a message says is stored. In the other order one forged message with a time
far ahead would lock a genuine sender out for good. Signing does not encrypt: messages stay
readable.
"""

import hashlib
import hmac
import struct
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from rocsafe_geo.storage.secret_file import SecretFileError, read_secret
from rocsafe_mavlink.errors import KeyFileError
from rocsafe_mavlink.wire.framing import SIGNATURE_SIZE, MavlinkFrame
from rocsafe_mavlink.wire.timestamp_store import StreamKey, TimestampStore

KEY_SIZE = 32
# 2015-01-01 in seconds since 1970; time stamps count 10 microseconds since then.
EPOCH_S = 1_420_070_400
TICKS_PER_S = 100_000
LARGEST_TICKS = 2**48 - 1
# The first message of a stream may lag behind our own time by this much.
NEW_STREAM_LAG_TICKS = 60 * TICKS_PER_S
MAC_SIZE = 6


class SignatureVerdict(Enum):
    """Result of the check of a signature."""

    GOOD = 'good'
    FORGED = 'bad signature'
    REPLAYED = 'old time stamp'
    TOO_OLD = 'new stream with an old time stamp'
    TOO_MANY_STREAMS = 'too many streams'


@dataclass(frozen=True, slots=True)
class SigningKey:
    """32 secret bytes that are never printed."""

    secret: bytes = field(repr=False)

    def __post_init__(self) -> None:
        if len(self.secret) != KEY_SIZE:
            raise ValueError(f'a signing key has {KEY_SIZE} bytes, not {len(self.secret)}')

    def mac(self, data: bytes) -> bytes:
        """Return the 48 bits that sign `data`."""
        return hashlib.sha256(self.secret + data).digest()[:MAC_SIZE]


def read_key(path: Path) -> SigningKey:
    """Return the key in a file that only its owner can read: 32 bytes or 64 hexadecimal digits.

    Raises
    ------
    KeyFileError
        Naming the file and what is wrong with it, never its content.
    """
    try:
        content = read_secret(path)
    except SecretFileError as error:
        raise KeyFileError(f'signing key {error}') from None
    if len(content) != KEY_SIZE:
        content = _from_hexadecimal(path, content)
    return SigningKey(content)


def ticks_at(time_s: float) -> int:
    """Return the time stamp of `time_s` seconds since 1970."""
    return min(max(0, int((time_s - EPOCH_S) * TICKS_PER_S)), LARGEST_TICKS)


class Signer:
    """Signs what we send, with time stamps that also rise across restarts."""

    def __init__(self, key: SigningKey, link_id: int, store: TimestampStore) -> None:
        self._key = key
        self._link_id = link_id
        self._store = store

    @property
    def fault(self) -> str:
        """Why its time stamps are not on disk; empty: they are."""
        return self._store.fault

    def signature(self, frame: bytes, time_s: float) -> bytes:
        """Return the signature of `frame`, a whole frame up to its checksum, to be appended."""
        ticks = self._store.next_sent(ticks_at(time_s))
        stamp = struct.pack('<BQ', self._link_id, ticks)[:7]
        return stamp + self._key.mac(frame + stamp)


class SignatureGate:
    """Checks the signatures of received frames."""

    def __init__(self, key: SigningKey, store: TimestampStore) -> None:
        self._key = key
        self._store = store

    def judge(self, frame: MavlinkFrame, time_s: float) -> SignatureVerdict:
        """Return the verdict on a signed `frame`; only a good one is stored."""
        if not hmac.compare_digest(self._key.mac(frame.data[:-MAC_SIZE]), frame.data[-MAC_SIZE:]):
            return SignatureVerdict.FORGED
        trailer = frame.data[-SIGNATURE_SIZE:]
        ticks = int.from_bytes(trailer[1:7], 'little')
        stream: StreamKey = (trailer[0], frame.system, frame.component)
        last = self._store.last_of(stream)
        if last is not None and ticks <= last:
            return SignatureVerdict.REPLAYED
        if last is None and ticks + NEW_STREAM_LAG_TICKS < self._store.newest(ticks_at(time_s)):
            return SignatureVerdict.TOO_OLD
        if last is None and self._store.is_full:
            return SignatureVerdict.TOO_MANY_STREAMS
        self._store.accept(stream, ticks)
        return SignatureVerdict.GOOD


def _from_hexadecimal(path: Path, content: bytes) -> bytes:
    try:
        key = bytes.fromhex(content.decode('ascii').strip())
    except ValueError:
        key = b''
    if len(key) != KEY_SIZE:
        # Not chained: the cause would quote the content of the file.
        raise KeyFileError(
            f'signing key {path} must hold {KEY_SIZE} bytes or {2 * KEY_SIZE} hexadecimal digits'
        ) from None
    return key
