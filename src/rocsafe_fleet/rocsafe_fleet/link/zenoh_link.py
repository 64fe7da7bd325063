# SPDX-License-Identifier: Apache-2.0
"""Packets between agents over Zenoh: one TCP connection a pair of hosts, for thin radios.

Needs `pip install eclipse-zenoh` (used under its Apache-2.0 licence). TCP repairs what the radio
loses; UDP sessions were never complete with 20 % loss. A packet that finds no room is dropped.
"""

import ipaddress
import json
from collections import deque
from collections.abc import Sequence
from importlib import import_module
from typing import Any

from rocsafe_fleet.errors import LinkError

# Packets that may wait for the agents.
MOST_WAITING = 1000
# First wait before another try to reach a peer, milliseconds; each further wait is twice as long.
FIRST_RETRY_MS, LONGEST_RETRY_MS = 500, 4000


class ZenohLink:
    """A peer of Zenoh that listens at one address and connects to others, without multicast.

    Parameters
    ----------
    fleet
        Name of the fleet: letters, digits, ``-`` and ``_``.
    listen
        Own address, ``host:port``.
    peers
        Addresses of the others.

    Raises
    ------
    LinkError
        If Zenoh is not installed, or the address cannot be opened.
    """

    def __init__(self, fleet: str, listen: str, peers: Sequence[str]) -> None:
        self.bytes_sent = self.bytes_received = 0
        self._waiting: deque[bytes] = deque(maxlen=MOST_WAITING)
        zenoh = _zenoh()
        try:
            self._session = zenoh.open(_config(zenoh, listen, peers))
        except zenoh.ZError as error:
            raise LinkError(f'{listen}: cannot be opened by Zenoh: {_first(error)}') from error
        key = f'rocsafe/{fleet}/delta'
        self._publisher = self._session.declare_publisher(
            key, congestion_control=zenoh.CongestionControl.DROP
        )
        # Called in a thread of Zenoh; own packets do not come back.
        self._session.declare_subscriber(
            key, self._on_sample, allowed_origin=zenoh.Locality.REMOTE
        )

    def _on_sample(self, sample: Any) -> None:
        self._waiting.append(sample.payload.to_bytes())

    def send(self, data: bytes) -> None:
        """Send a packet to all peers that are connected."""
        self.bytes_sent += len(data)
        self._publisher.put(data)

    def receive(self) -> list[bytes]:
        """Return the packets that have come since the last call."""
        found = []
        while self._waiting:
            found.append(self._waiting.popleft())
        self.bytes_received += sum(map(len, found))
        return found

    def close(self) -> None:
        """End all connections."""
        self._session.close()


def _zenoh() -> Any:
    try:
        return import_module('zenoh')
    except ImportError as error:
        raise LinkError('link = zenoh needs: pip install eclipse-zenoh') from error


def _config(zenoh: Any, listen: str, peers: Sequence[str]) -> Any:
    for address in (listen, *peers):
        _require_address(address)
    config = zenoh.Config()
    retry = {'period_init_ms': FIRST_RETRY_MS, 'period_max_ms': LONGEST_RETRY_MS}
    for key, value in (
        ('mode', 'peer'),
        ('listen/endpoints', [f'tcp/{listen}']),
        ('connect/endpoints', [f'tcp/{peer}' for peer in peers]),
        ('connect/timeout_ms', 0),
        ('connect/exit_on_failure', False),
        ('connect/retry', {**retry, 'period_increase_factor': 2}),
        ('scouting/multicast/enabled', False),
        ('scouting/gossip/enabled', False),
        # Segments stay after the process, whether it was killed or not.
        ('transport/shared_memory/enabled', False),
    ):
        config.insert_json5(key, json.dumps(value))
    return config


def _require_address(text: str) -> None:
    host, _, port = text.rpartition(':')
    try:
        ipaddress.IPv4Address(host)
        is_port = 0 < int(port) < 2**16
    except ValueError:
        is_port = False
    if not is_port:
        raise LinkError(f'{text!r}: must be an IPv4 address and a port, such as 10.9.0.1:47613')


def _first(error: Exception) -> str:
    return str(error).partition(' at /')[0].splitlines()[0]
