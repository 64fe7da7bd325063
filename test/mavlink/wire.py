# SPDX-License-Identifier: Apache-2.0
"""The far end of a link, as bytes."""

import os

from rocsafe_mavlink.link.link import Link, LinkRules
from rocsafe_mavlink.wire.dialect import Message, encode
from rocsafe_mavlink.wire.framing import SIGNATURE_SIZE, pack_frame
from rocsafe_mavlink.wire.signing import SignatureGate, Signer, SigningKey, ticks_at
from rocsafe_mavlink.wire.timestamp_store import TimestampStore

DRONE = ('127.0.0.1', 14551)
STRANGER = ('127.0.0.1', 40000)
KEY = SigningKey(bytes(range(32)))
WRONG_KEY = SigningKey(b'x' * 32)
# 2026-01-01.
NOW_S = 1_767_225_600.0
FUZZ_COUNT = int(os.environ.get('ROCSAFE_FUZZ_DATAGRAMS', '100000'))
POSITION = Message(
    'GLOBAL_POSITION_INT',
    {'time_boot_ms': 1000, 'lat': 473977420, 'lon': 85455940, 'alt': 488000, 'hdg': 9000},
)
HEARTBEAT = Message(
    'HEARTBEAT', {'type': 2, 'autopilot': 3, 'system_status': 3, 'mavlink_version': 3}
)


def frame(message=POSITION, sequence=0, system=1):
    """Return an unsigned frame from a drone."""
    return pack_frame(*encode(message), system, 1, sequence, sign=False)


def signed_frame(message=POSITION, *, key=KEY, time_s=NOW_S, link_id=1):
    """Return a signed frame from a drone whose clock says `time_s`."""
    body = pack_frame(*encode(message), 1, 1, 0, sign=True)
    return body + Signer(key, link_id, TimestampStore()).signature(body, time_s)


def with_ticks(signed, time_s):
    """Return a signed frame whose time stamp is replaced, its signature not."""
    trailer = signed[-SIGNATURE_SIZE:]
    forged = trailer[:1] + ticks_at(time_s).to_bytes(6, 'little') + trailer[7:]
    return signed[:-SIGNATURE_SIZE] + forged


def open_link(**rules):
    """Return an unsigned link that hears the drone."""
    return Link(LinkRules(**{'allowed': frozenset({DRONE}), **rules}))


def signed_link(path=None, allowed=(DRONE,)):
    """Return a link that believes only the key."""
    store = TimestampStore(path)
    return Link(
        LinkRules(allowed=frozenset(allowed)),
        gate=SignatureGate(KEY, store),
        signer=Signer(KEY, 0, store),
    )
