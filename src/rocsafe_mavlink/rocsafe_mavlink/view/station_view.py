# SPDX-License-Identifier: Apache-2.0
"""All shown vehicles on one link to a ground station."""

from collections import Counter
from collections.abc import Iterable

from rocsafe_mavlink.link.endpoint import Endpoint
from rocsafe_mavlink.link.transport import Transport, address_of, open_transport
from rocsafe_mavlink.view.answers import answers
from rocsafe_mavlink.view.sight import Sight
from rocsafe_mavlink.view.telemetry_messages import fast_messages, slow_messages
from rocsafe_mavlink.wire.dialect import Message, decode, encode
from rocsafe_mavlink.wire.framing import pack_frame, scan

# Systems from 251 on are those of ground stations.
MOST_VEHICLES = 250
EVERYBODY = 0


class StationView:
    """Shows vehicles to a ground station and answers its requests.

    Parameters
    ----------
    endpoint
        Where the station listens.

    Attributes
    ----------
    sights
        What is shown of each vehicle, by name.

    Raises
    ------
    EndpointError
        If it cannot be opened.
    """

    def __init__(self, endpoint: Endpoint) -> None:
        self._transport: Transport = open_transport(endpoint)
        self._address = address_of(endpoint)
        self._sequences: Counter[int] = Counter()
        self.sights: dict[str, Sight] = {}

    def add(self, name: str) -> Sight:
        """Return what is shown of a vehicle; a new one gets the next free system.

        Raises
        ------
        ValueError
            If there are more vehicles than MAVLink has systems for.
        """
        if name not in self.sights:
            if len(self.sights) == MOST_VEHICLES:
                raise ValueError(f'{name}: at most {MOST_VEHICLES} vehicles can be shown')
            self.sights[name] = Sight(system=len(self.sights) + 1)
        return self.sights[name]

    def show(self, time_ms: int, *, is_slow: bool) -> None:
        """Send where all vehicles are; with `is_slow` also heartbeat, battery, home."""
        for sight in self.sights.values():
            if is_slow:
                self._send(slow_messages(sight, time_ms))
            self._send(fast_messages(sight, time_ms))

    def answer(self, now_s: float) -> None:
        """Answer all that the station has asked since the last call."""
        for _sender, data in self._transport.take(now_s):
            for frame in scan(data, is_whole=True).frames:
                asked = decode(frame.message_id, frame.payload, frame.system, frame.component)
                for sight in self._meant(asked):
                    self._send(answers(sight, asked))

    def close(self) -> None:
        """Close the link."""
        self._transport.close()

    def _meant(self, asked: Message) -> list[Sight]:
        system = asked.fields.get('target_system')
        shown = self.sights.values()
        return [one for one in shown if system in (EVERYBODY, one.system)]

    def _send(self, messages: Iterable[Message]) -> None:
        for message in messages:
            number = self._sequences[message.system] % 256
            self._sequences[message.system] += 1
            frame = pack_frame(
                *encode(message), message.system, message.component, number, sign=False
            )
            self._transport.send(self._address, frame)
