# SPDX-License-Identifier: Apache-2.0
"""Frames in bytes: begin and end of each message, and its checksum.

Format: https://mavlink.io/en/guide/serialization.html. A frame counts only if its message is known
and its checksum right. Anything else is skipped by one byte, so that a false start cannot swallow
a good message behind it.
"""

import re
import struct
from dataclasses import dataclass

from rocsafe_mavlink.wire.dialect import CRC_EXTRAS, checksum

MAGIC_1, MAGIC_2 = 0xFE, 0xFD
HEADER_1, HEADER_2 = 6, 10
CHECKSUM_SIZE = 2
SIGNATURE_SIZE = 13
LARGEST_FRAME = HEADER_2 + 255 + CHECKSUM_SIZE + SIGNATURE_SIZE
SIGNED_FLAG = 0x01
_MAGIC = re.compile(b'[\xfd\xfe]')


@dataclass(frozen=True, slots=True)
class MavlinkFrame:
    """One whole frame with a right checksum.

    Attributes
    ----------
    data
        All bytes, from the magic byte to the end.
    message_id, system, component, sequence
        Fields of the header.
    payload
        Zeros at its end may be cut off.
    is_signed
        Whether it carries a signature, right or wrong.
    """

    data: bytes
    message_id: int
    system: int
    component: int
    sequence: int
    payload: bytes
    is_signed: bool


@dataclass(slots=True)
class Scan:
    """What was found in a piece of bytes.

    Attributes
    ----------
    frames
        Frames, in order.
    used
        Number of bytes that need not be looked at again.
    false_starts
        Number of places that looked like a frame but were none.
    """

    frames: list[MavlinkFrame]
    used: int = 0
    false_starts: int = 0


def scan(data: bytes, *, is_whole: bool) -> Scan:
    """Return the frames in `data`.

    With `is_whole` (a datagram) nothing follows. Otherwise (a stream) the rest may hold the start
    of a frame, which starts at `used`.
    """
    found = Scan([])
    while (start := _MAGIC.search(data, found.used)) is not None:
        found.used = start.start()
        size = _frame_size(data, found.used)
        is_cut = size == 0 or found.used + size > len(data)
        if is_cut and not is_whole:
            return found
        frame = None if is_cut else _frame(data[found.used : found.used + size])
        if frame is None:
            found.false_starts += 1
            found.used += 1
        else:
            found.frames.append(frame)
            found.used += size
    found.used = len(data)
    return found


def pack_frame(
    message_id: int, payload: bytes, system: int, component: int, sequence: int, *, sign: bool
) -> bytes:
    """Return a MAVLink 2 frame up to its checksum; with `sign` a signature has to follow."""
    short = payload.rstrip(b'\0') or payload[:1]
    flags = SIGNED_FLAG if sign else 0
    head = struct.pack(
        '<BBBBBBBHB',
        MAGIC_2,
        len(short),
        flags,
        0,
        sequence,
        system,
        component,
        message_id & 0xFFFF,
        message_id >> 16,
    )
    body = head + short
    return body + struct.pack('<H', checksum(body[1:] + CRC_EXTRAS[message_id]))


def _frame_size(data: bytes, start: int) -> int:
    """Return the size that the frame at `start` claims to have; 0 if even that is missing."""
    if len(data) < start + 3:
        return 0
    length = data[start + 1] + CHECKSUM_SIZE
    if data[start] == MAGIC_1:
        return HEADER_1 + length
    signature = SIGNATURE_SIZE if data[start + 2] & SIGNED_FLAG else 0
    return HEADER_2 + length + signature


def _frame(data: bytes) -> MavlinkFrame | None:
    """Return the frame that `data` is, or None."""
    if data[0] == MAGIC_1:
        head, is_signed, message_id = HEADER_1, False, data[5]
        sequence, system, component = data[2:5]
    else:
        head, is_signed = HEADER_2, bool(data[2] & SIGNED_FLAG)
        sequence, system, component = data[4:7]
        message_id = int.from_bytes(data[7:10], 'little')
        if data[2] & ~SIGNED_FLAG:
            # The standard forbids reading a frame with an unknown flag.
            return None
    end = head + data[1]
    extra = CRC_EXTRAS.get(message_id)
    if extra is None or not system or not component:
        return None
    if checksum(data[1:end] + extra) != int.from_bytes(data[end : end + 2], 'little'):
        return None
    return MavlinkFrame(data, message_id, system, component, sequence, data[head:end], is_signed)
