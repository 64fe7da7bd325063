# SPDX-License-Identifier: Apache-2.0
"""Sends orders to vehicles, by the same calls as the command line.

Hold, resume, return and land go through the node ``fleet_verbs``, which serves them for one and
for all; where there is none, and for what it does not serve, the vehicle itself is asked.
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from rclpy.client import Client
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import Trigger

from rocsafe_console.drives_node import Drives
from rocsafe_console.orders.order_book import Order, Outcome, Result, Target
from rocsafe_console.people.roles import Action
from rocsafe_interfaces.msg import GeoPoint
from rocsafe_interfaces.srv import FleetCommand, GoTo, Lease, Resume
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.interface_spec import CallSpec, name_of

ANSWER_S = 5.0
LOOK_S = 0.05
# A lease of an operator ends by itself if the console dies.
LEASE_S = 60.0
RENEW_S = 15.0
FLEET = {
    Action.HOLD: calls.FLEET_HOLD,
    Action.RESUME: calls.FLEET_RESUME,
    Action.RETURN: calls.FLEET_RETURN_HOME,
    Action.LAND: calls.FLEET_LAND,
}
ALONE = {
    Action.HOLD: calls.HOLD,
    Action.RETURN: calls.RETURN_HOME,
    Action.LAND: calls.LAND,
}
MISSION_CALLS = {Action.REPLAN: calls.REPLAN}
VEHICLE_CALLS = (*ALONE.values(), calls.RESUME, calls.LEASE, calls.GO_TO)

Finish = Callable[[tuple[Result, ...]], None]


@dataclass(slots=True)
class _Waiting:
    """An order under way: the results so far, and who wants them."""

    names: tuple[str, ...]
    finish: Finish
    until_s: float
    results: dict[str, Result] = field(default_factory=dict)


@dataclass(slots=True)
class _Held:
    """A lease of an operator, kept until it is given back."""

    user: str
    lease: str
    renew_s: float


class Orders:
    """Sends orders; each vehicle is asked, whatever the others answer.

    All methods belong to the thread of the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._fleet = {
            action: node.create_client(spec.call_type, spec.name) for action, spec in FLEET.items()
        }
        self._mission = {
            action: node.create_client(spec.call_type, spec.name)
            for action, spec in MISSION_CALLS.items()
        }
        self.drives = Drives(node)
        self._calls: dict[tuple[CallSpec, str], Client] = {}
        self._waiting: list[_Waiting] = []
        self._held: dict[str, _Held] = {}
        node.create_timer(LOOK_S, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    def add(self, vehicle: str) -> None:
        """Make the clients of a vehicle."""
        for spec in VEHICLE_CALLS:
            name = name_of(spec, vehicle)
            self._calls[spec, vehicle] = self._node.create_client(spec.call_type, name)

    def send(self, order: Order, names: tuple[str, ...], finish: Finish) -> None:
        """Send an order to some of its vehicles; `finish` gets one result of each, in time."""
        waiting = _Waiting(names, finish, time.monotonic() + ANSWER_S)
        self._waiting.append(waiting)
        if order.verb in self._mission:
            self._send_to_mission(order.verb, waiting)
            return
        led = {name for name in names if self._is_held(name, order.user)}
        fleet = self._fleet.get(order.verb)
        if fleet is not None and fleet.service_is_ready():
            # The holder of the lease resumes the vehicle with it.
            own = led if order.verb is Action.RESUME else set()
            self._send_to_fleet(fleet, [name for name in names if name not in own], waiting)
            names = tuple(own)
        for name in names:
            self._send_to_one(order, name, waiting)

    def _send_to_fleet(self, client: Client, names: list[str], waiting: _Waiting) -> None:
        def on_answer(future: Any) -> None:
            for answer in future.result().answers:
                outcome = Outcome.SILENT if answer.is_silent else None
                self._note(waiting, answer.vehicle, answer.success, answer.message, outcome)

        if names:
            request = FleetCommand.Request(vehicles=names)
            client.call_async(request).add_done_callback(on_answer)

    def _send_to_mission(self, verb: Action, waiting: _Waiting) -> None:
        """Ask the mission; what it answers holds for each of its vehicles."""

        def note_all(success: bool, text: str) -> None:
            for name in waiting.names:
                self._note(waiting, name, success, text)

        client = self._mission[verb]
        if not client.service_is_ready():
            note_all(False, 'the mission cannot be reached')
            return

        def on_answer(future: Any) -> None:
            note_all(future.result().success, future.result().message)

        client.call_async(Trigger.Request()).add_done_callback(on_answer)

    def _send_to_one(self, order: Order, name: str, waiting: _Waiting) -> None:
        held = self._held.get(name)
        lease = held.lease if held is not None and held.user == order.user else ''
        if order.verb in ALONE:
            self._ask(ALONE[order.verb], Trigger.Request(), name, waiting)
        elif order.verb is Action.RESUME:
            self._ask(calls.RESUME, Resume.Request(lease=lease), name, waiting)
        elif order.verb is Action.SEND:
            self.drives.drive(order, name, lease, partial(self._note, waiting, name))
        elif isinstance(order.target, Target):
            target = order.target
            point = GeoPoint(latitude=target.latitude_deg, longitude=target.longitude_deg)
            request = GoTo.Request(lease=lease, position=point, height_m=target.height_m)
            self._ask(calls.GO_TO, request, name, waiting)
        elif order.verb is Action.TAKE:
            self._take(order.user, name, waiting)
        elif lease:
            self._release(name, lease, waiting)
        else:
            self._note(waiting, name, False, f'{name}: {order.user} does not lead it')

    def _take(self, user: str, name: str, waiting: _Waiting) -> None:
        """Take the lease over, which is deliberate: the operator has confirmed it."""

        def on_answer(answer: Any) -> None:
            if answer.success:
                due_s = time.monotonic() + RENEW_S
                self._held[name] = _Held(user, answer.control.lease, due_s)
            self._note(waiting, name, answer.success, answer.message)

        request = Lease.Request(holder=f'{user}@console', duration_s=LEASE_S, take_over=True)
        self._ask(calls.LEASE, request, name, waiting, on_answer)

    def _release(self, name: str, lease: str, waiting: _Waiting) -> None:
        self._held.pop(name, None)
        request = Lease.Request(request=Lease.Request.RELEASE, lease=lease)
        self._ask(calls.LEASE, request, name, waiting)

    def _ask(
        self,
        spec: CallSpec,
        request: Any,
        name: str,
        waiting: _Waiting,
        then: Callable[[Any], None] | None = None,
    ) -> None:
        client = self._calls.get((spec, name))
        if client is None or not client.service_is_ready():
            self._note(waiting, name, False, f'{name}: cannot be reached')
            return

        def on_answer(future: Any) -> None:
            answer = future.result()
            if then is not None:
                then(answer)
            else:
                self._note(waiting, name, answer.success, answer.message)

        client.call_async(request).add_done_callback(on_answer)

    def _note(
        self,
        waiting: _Waiting,
        name: str,
        success: bool,
        text: str,
        outcome: Outcome | None = None,
    ) -> None:
        outcome = outcome or (Outcome.DONE if success else Outcome.REFUSED)
        waiting.results.setdefault(name, Result(vehicle=name, outcome=outcome, text=text))

    def _is_held(self, name: str, user: str) -> bool:
        held = self._held.get(name)
        return held is not None and held.user == user

    def _look(self) -> None:
        """Finish the orders that are answered or late, and renew leases."""
        self.drives.look()
        now_s = time.monotonic()
        for waiting in list(self._waiting):
            if len(waiting.results) == len(waiting.names) or now_s > waiting.until_s:
                self._waiting.remove(waiting)
                waiting.finish(_all_results(waiting.names, waiting.results))
        for name, held in list(self._held.items()):
            if now_s >= held.renew_s:
                held.renew_s = now_s + RENEW_S
                self._renew(name, held)

    def _renew(self, name: str, held: _Held) -> None:
        def on_answer(future: Any) -> None:
            if not future.result().success and self._held.get(name) is held:
                del self._held[name]

        request = Lease.Request(request=Lease.Request.RENEW, lease=held.lease, duration_s=LEASE_S)
        client = self._calls[calls.LEASE, name]
        if client.service_is_ready():
            client.call_async(request).add_done_callback(on_answer)


def _all_results(names: tuple[str, ...], found: Mapping[str, Result]) -> tuple[Result, ...]:
    silent = f'no answer within {ANSWER_S:g} s'
    return tuple(
        found.get(name) or Result(vehicle=name, outcome=Outcome.SILENT, text=f'{name}: {silent}')
        for name in sorted(names)
    )
