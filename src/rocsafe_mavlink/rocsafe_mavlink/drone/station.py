# SPDX-License-Identifier: Apache-2.0
"""A ground station for the drones on one link: the only place where bytes are sent and received.

Drones are told apart by (system, component), never by address alone. Heartbeats are sent only
while the supervisor lives: without them a drone notices that it is alone.
"""

from dataclasses import replace

from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.readout import Target
from rocsafe_mavlink.errors import NotAllowedError
from rocsafe_mavlink.link.link import Address, Link
from rocsafe_mavlink.link.transport import Transport
from rocsafe_mavlink.wire.counters import Reason
from rocsafe_mavlink.wire.dialect import Message

HEARTBEAT_PERIOD_S = 1.0
# Data of a payload; its component is not the autopilot.
TUNNEL = 'TUNNEL'
# MAV_TYPE_GCS, MAV_AUTOPILOT_INVALID, MAV_STATE_ACTIVE.
HEARTBEAT = Message(
    'HEARTBEAT', {'type': 6, 'autopilot': 8, 'system_status': 4, 'mavlink_version': 3}
)


class Station:
    """Routes messages between a link and its drones; other vehicles on the link are ignored.

    Parameters
    ----------
    transport
        Carries the bytes.
    link
        Reads and writes them.
    instance
        Number of this process in its heartbeats, a field that means nothing there: with it they
        are known where a link gives back what it is sent.
    """

    def __init__(self, transport: Transport, link: Link, instance: int = 0) -> None:
        self.link = link
        self._beat = replace(HEARTBEAT, fields={**HEARTBEAT.fields, 'custom_mode': instance})
        self._transport = transport
        self._drones: dict[Target, Drone] = {}
        self._beat_s = -HEARTBEAT_PERIOD_S

    def add(self, drone: Drone) -> None:
        """Serve a drone from now on."""
        self._drones[drone.spec.target] = drone

    def take(self, now_s: float, time_s: float) -> None:
        """Take what has come, and answer it.

        Parameters
        ----------
        now_s
            Steady time, seconds.
        time_s
            Time of day, seconds since 1970.
        """
        self.flush(now_s, time_s)
        for address, data in self._transport.take(now_s):
            for message in self.link.receive(address, data, now_s, time_s):
                self._route(address, message, now_s)
            self.flush(now_s, time_s)

    def discard(self, now_s: float) -> None:
        """Throw away what has come: nobody can tell when it was sent."""
        self._transport.discard(now_s)

    def tick(self, now_s: float, time_s: float, *, is_supervised: bool) -> None:
        """Let time pass, and send what is due.

        Parameters
        ----------
        now_s, time_s
            As in `take`.
        is_supervised
            Whether the supervisor lives.
        """
        if is_supervised and now_s - self._beat_s >= HEARTBEAT_PERIOD_S - 1e-6:
            self._beat_s = now_s
            for peer in self.link.stations:
                self._transport.send(peer, self.link.pack(self._beat, now_s, time_s))
        for drone in self._drones.values():
            drone.session.tick(now_s)
        self.flush(now_s, time_s)

    def flush(self, now_s: float, time_s: float) -> None:
        """Send what waits in the queues of the drones."""
        for drone in self._drones.values():
            for message in drone.session.outgoing():
                self._send(drone.session.address, message, now_s, time_s)

    def close(self) -> None:
        """Close the transport."""
        self._transport.close()

    def _route(self, address: Address, message: Message, now_s: float) -> None:
        drone = self._drones.get((message.system, message.component))
        if message.name == TUNNEL:
            drone = self._carrier_of(message.system, address)
            if drone is not None:
                drone.take_beside(message)
                return
        if message.name == 'HEARTBEAT' and message['custom_mode'] != self._beat['custom_mode']:
            self._hear_twin(message.system, now_s)
        if drone is None:
            self.link.counters.drop(Reason.UNKNOWN_PEER)
            return
        before = drone.session.address
        if not drone.session.may_hear(address, self.link, now_s):
            self.link.counters.drop(Reason.IMPOSTOR)
            return
        if drone.session.address != before:
            held = (served.session.address for served in self._drones.values())
            self.link.held = frozenset(one for one in held if one is not None)
        drone.take(message, now_s)

    def _hear_twin(self, system: int, now_s: float) -> None:
        """Note another station that says to be us."""
        for drone in self._drones.values():
            if drone.session.us[0] == system:
                drone.session.twin_s = now_s

    def _carrier_of(self, system: int, address: Address) -> Drone | None:
        """Return the drone whose system sends from an address; any of its components may send."""
        for target, drone in self._drones.items():
            if target[0] == system and drone.session.address == address:
                return drone
        return None

    def _send(
        self, address: Address | None, message: Message, now_s: float, time_s: float
    ) -> None:
        try:
            data = self.link.pack(message, now_s, time_s)
        except NotAllowedError:
            # Too many at once: who sends commands repeats them.
            self.link.counters.drop(Reason.NOT_SENT)
            return
        self._transport.send(address, data)
