# SPDX-License-Identifier: Apache-2.0
"""Limits of a link on traffic and memory, and the period of reopening it."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkLimits:
    """Limits of one link, far above what vehicles send.

    Attributes
    ----------
    peers
        Addresses that are remembered beside those of the vehicles, which are never forgotten.
    late_holders, late_for_s
        Holders of the key whose clock is behind: how many get heartbeats, and for how long,
        seconds.
    datagram_bytes
        A larger datagram is dropped.
    messages_per_s
        Messages that one address may send.
    senders
        MAVLink senders of one address whose losses are counted.
    sequence_gap
        A larger gap in the sequence is a restart of the sender, not a loss.
    pieces, piece_bytes
        One call takes at most this many pieces, of at most this size, so that a flood cannot
        block its caller.
    discards
        So many calls throw away what a buffer of the system holds.
    retry_s
        Time between two attempts to open a connection, seconds.
    """

    peers: int = 32
    late_holders: int = 8
    late_for_s: float = 3.0
    datagram_bytes: int = 4096
    messages_per_s: float = 2000.0
    senders: int = 64
    sequence_gap: int = 128
    pieces: int = 256
    piece_bytes: int = 65_535
    discards: int = 64
    retry_s: float = 1.0


LINK_LIMITS = LinkLimits()
