# SPDX-License-Identifier: Apache-2.0
"""The control leases that a mission or an agent holds of its vehicles: taken, and kept."""

import os
import socket
import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from rclpy.client import Client
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_interfaces.msg import Control
from rocsafe_interfaces.srv import Lease
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import name_of
from rocsafe_ros.lease.control_lease import MISSION_VARIABLE, server_of

# A mission that has died leaves its vehicles to others after this time.
LEASE_S = 60.0
RENEW_S = 20.0
LOOK_S = 0.5
# A request without an answer is sent again after this time.
REPEAT_S = 5.0

Send = Callable[[str], None]


class Leases:
    """Takes the lease of each vehicle as soon as it can be reached, and renews it.

    One that is lost, because somebody else has taken it or it is void, is not asked for again:
    the vehicle then refuses the orders of this mission, and says who leads it.

    Parameters
    ----------
    node
        Node that owns the clients.
    vehicles
        Names of the vehicles.
    mission
        Name of the mission.
    say
        Called with one line for people when a lease is lost.
    role
        What the node is for the vehicles: the name of the holder, before that of the machine.
    is_reserve
        Whether it takes a lease only when an order needs it, and then from another holder, too.

    Attributes
    ----------
    lost
        Vehicles whose lease is lost.
    led_by_others
        Those of them that no node of this mission leads: it must not command them at all.
    """

    def __init__(
        self,
        node: Node,
        vehicles: Iterable[str],
        mission: str,
        say: Callable[[str], None],
        *,
        role: str,
        is_reserve: bool = False,
    ) -> None:
        self._mission = mission
        self._holder = f'{role}@{socket.gethostname()}'
        self._is_reserve = is_reserve
        self._token = os.environ.get(MISSION_VARIABLE, '')
        self._say = say
        self._clients: dict[str, Client] = {
            name: node.create_client(calls.LEASE.call_type, name_of(calls.LEASE, name))
            for name in vehicles
        }
        self._held: dict[str, str] = {}
        self.lost: set[str] = set()
        self.led_by_others: set[str] = set()
        self._due_s = dict.fromkeys(self._clients, 0.0)
        self._waiting: dict[str, tuple[Send, Callable[[str], None]]] = {}
        for name in self._clients:
            topics.create_subscription(node, topics.CONTROL, partial(self._on_control, name), name)
        node.create_timer(LOOK_S, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def carry(self, vehicle: str, send: Send, refuse: Callable[[str], None]) -> None:
        """Call `send` with the lease of a vehicle as soon as it is held, else `refuse`."""
        if vehicle in self._held:
            send(self._held[vehicle])
            return
        self._waiting[vehicle] = send, refuse
        self._due_s[vehicle] = 0.0
        self._look()

    def _look(self) -> None:
        now_s = time.monotonic()
        for vehicle, client in self._clients.items():
            is_wanted = not self._is_reserve or vehicle in self._held or vehicle in self._waiting
            is_due = now_s >= self._due_s[vehicle] and is_wanted and vehicle not in self.lost
            if is_due and client.service_is_ready():
                self._due_s[vehicle] = now_s + REPEAT_S
                answer = client.call_async(self._request(vehicle))
                answer.add_done_callback(partial(self._on_answer, vehicle))

    def _request(self, vehicle: str) -> Any:
        held = self._held.get(vehicle, '')
        return Lease.Request(
            request=Lease.Request.RENEW if held else Lease.Request.TAKE,
            holder=self._holder,
            mission=self._mission,
            lease=held,
            duration_s=LEASE_S,
            take_over=self._is_reserve and not held,
            server=server_of(vehicle, self._token) if self._token else '',
        )

    def _on_answer(self, vehicle: str, future: Any) -> None:
        answer = future.result()
        if answer.success:
            self._held[vehicle] = answer.control.lease
            self._due_s[vehicle] = time.monotonic() + RENEW_S
        elif vehicle in self._held:
            self._lose(vehicle, answer.control.mission, answer.message)
        waiting = self._waiting.pop(vehicle, None)
        if waiting is not None:
            send, refuse = waiting
            send(self._held[vehicle]) if answer.success else refuse(answer.message)

    def _on_control(self, vehicle: str, message: Control) -> None:
        """Note at once that somebody else was given the lease."""
        held = self._held.get(vehicle, '')
        is_ours = message.server == held.partition('/')[0]
        if held and is_ours and message.lease not in ('', held):
            self._lose(vehicle, message.mission, f'{vehicle}: {message.text}')

    def _lose(self, vehicle: str, mission: str, why: str) -> None:
        if vehicle in self.lost:
            return
        self.lost.add(vehicle)
        if mission != self._mission:
            self.led_by_others.add(vehicle)
            self._say(f'{why}: it takes no orders of this mission')
