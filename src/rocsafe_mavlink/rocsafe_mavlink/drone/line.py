# SPDX-License-Identifier: Apache-2.0
"""A transport with a station at its end: the one place where bytes meet the world."""

from collections.abc import Callable

from rocsafe_mavlink.drone.station import Outgoing, Station, Target
from rocsafe_mavlink.knowledge.events import Event
from rocsafe_mavlink.link.transport import Transport
from rocsafe_mavlink.wire.dialect import Message

OnMessage = Callable[[Message], None]
OnEvent = Callable[[Event], None]


class Line:
    """Serves the vehicles on one transport.

    Parameters
    ----------
    name: of the link, for people.
    transport: bytes in and out.
    station: what is made of them.
    """

    def __init__(self, name: str, transport: Transport, station: Station) -> None:
        self.name = name
        self.station = station
        self._transport = transport
        self._listeners: dict[Target, tuple[OnMessage, OnEvent]] = {}

    def listen(self, target: Target, on_message: OnMessage, on_event: OnEvent) -> None:
        """Tell about the messages and events of a vehicle from now on."""
        self._listeners[target] = (on_message, on_event)

    def take(self, now_s: float, time_s: float) -> None:
        """Take what has come, and answer it.

        Parameters
        ----------
        now_s: steady time, seconds.
        time_s: time of day, seconds since 1970.
        """
        for address, data in self._transport.take(now_s):
            came = self.station.receive(address, data, now_s, time_s)
            for target, message in came.messages:
                if target in self._listeners:
                    self._listeners[target][0](message)
            for target, event in came.events:
                if target in self._listeners:
                    self._listeners[target][1](event)
            self.send(came.outgoing)

    def tick(self, now_s: float, time_s: float, *, is_supervised: bool) -> None:
        """Let time pass, and send what is due.

        Parameters
        ----------
        now_s, time_s: as in `take`.
        is_supervised: whether whoever supervises us lives.
        """
        self.send(self.station.tick(now_s, time_s, is_supervised=is_supervised))

    def send(self, outgoing: Outgoing) -> None:
        """Send what a station wants sent."""
        for address, data in outgoing:
            self._transport.send(address, data)

    def close(self) -> None:
        """Give the transport back."""
        self._transport.close()
