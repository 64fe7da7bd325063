# SPDX-License-Identifier: Apache-2.0
"""What agents need of a link: packets out, packets in, and how many bytes that was.

A link may lose, delay and repeat packets; the ledger does without them. It must not block.
"""

from typing import Protocol


class FleetLink(Protocol):
    """Carries the packets of agents to those of other processes.

    Attributes
    ----------
    bytes_sent, bytes_received
        Payload handed to it, and taken from it.
    """

    bytes_sent: int
    bytes_received: int

    def send(self, data: bytes) -> None:
        """Send a packet."""

    def receive(self) -> list[bytes]:
        """Return the packets that have come since the last call."""

    def close(self) -> None:
        """End the link."""
