# SPDX-License-Identifier: Apache-2.0
"""The command services of a real vehicle: answered when it has obeyed or refused."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rocsafe_mavlink.checks.check import failures
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.errors import CommandRefusedError
from rocsafe_mavlink.plan.fence import Fence
from rocsafe_mavlink.vehicle_interface.conversions import check_message, ring_of
from rocsafe_ros.conversions import position_of_point
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.interface_spec import CallSpec
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.control_lease import LeaseRefusedError
from rocsafe_ros.lease.server_node import LeaseServer

Begin = Callable[[Any, float], None]


class CommandServices:
    """Services: hold, return_home and land, always taken; with the lease all others.

    These are resume, go_to, set_speed, fence and rally; preflight commands nothing.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    drone
        The vehicle.
    lease
        Judges who may give orders.
    clock
        Returns steady time, seconds.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        drone: Drone,
        lease: LeaseServer,
        clock: Callable[[], float],
    ) -> None:
        self._node = node
        self._drone = drone
        self._lease = lease
        self._clock = clock
        self._waiting: list[_Answer] = []
        commands = drone.commands
        self._serve(calls.HOLD, lambda _request, now_s: commands.hold(now_s))
        self._serve(calls.RESUME, lambda _request, now_s: commands.resume(now_s))
        for spec, end in (
            (calls.RETURN_HOME, commands.return_home),
            (calls.LAND, commands.land),
        ):
            self._serve(spec, partial(_given, end), ends_flight=True)
        self._serve(calls.GO_TO, self._go_to)
        self._serve(
            calls.SET_SPEED,
            lambda request, now_s: commands.change_speed(request.speed_mps, now_s),
        )
        self._serve(calls.PUSH_FENCE, self._push_fence)
        self._serve(calls.PUSH_RALLY, self._push_rally)
        spec = calls.PREFLIGHT
        node.create_service(spec.call_type, spec.name, self._on_preflight)

    def step(self) -> None:
        """Answer the calls whose command is over."""
        waiting, self._waiting = self._waiting, []
        for answer in waiting:
            error = self._drone.commands.outcome(answer.number)
            if error is None:
                self._waiting.append(answer)
                continue
            if not error and answer.ends_flight:
                self._drone.gave_up()
            answer.give(error)

    def _serve(self, spec: CallSpec, begin: Begin, ends_flight: bool = False) -> None:
        """Serve a command; `ends_flight`: once obeyed, it ends the flight by request."""
        answers: list[_Answer] = []

        def on_call(request: Any, response: Any) -> Any:
            answer = _Answer(response, self._drone.spec.name, ends_flight)
            answers.append(answer)
            # Hold, return_home and land carry no lease.
            lease = getattr(request, 'lease', None)
            if lease is not None and self._lease.is_for_another(lease):
                return response  # that node answers
            now_s = self._clock()
            # A flight that has just been found may be resumed.
            self._drone.step(now_s)
            try:
                if lease is not None:
                    self._lease.require(lease)
                begin(request, now_s)
            except (LeaseRefusedError, CommandRefusedError, ValueError) as refusal:
                answer.give(str(refusal))
                return response
            answer.number = self._drone.commands.count
            self._waiting.append(answer)
            return response

        service = self._node.create_service(spec.call_type, spec.name, on_call)
        send = service.send_response

        def send_later(_response: Any, header: Any) -> None:
            answers.pop(0).address(lambda response: send(response, header))

        # The executors send the response by this method as soon as the callback returns.
        service.send_response = send_later

    def _go_to(self, request: Any, now_s: float) -> None:
        place = position_of_point(request.position)
        self._drone.commands.go_to(place, request.height_m, now_s)

    def _push_fence(self, request: Any, now_s: float) -> None:
        fence = Fence(
            inclusions=tuple(map(ring_of, request.inclusions)),
            exclusions=tuple(map(ring_of, request.exclusions)),
        )
        self._drone.commands.push_fence(fence, now_s)

    def _push_rally(self, request: Any, now_s: float) -> None:
        points = [position_of_point(point) for point in request.points]
        self._drone.commands.push_rally(points, request.height_m, now_s)

    def _on_preflight(self, _request: Any, response: Any) -> Any:
        try:
            checks = self._drone.checks_of_plan(self._clock())
        except ValueError as error:
            self._node.get_logger().warning(f'{self._drone.spec.name}: {error}')
            return response
        response.checks = [check_message(check) for check in checks]
        response.may_fly = not failures(checks)
        return response


def _given(command: Callable[[float], None], _request: Any, now_s: float) -> None:
    """Give a command that has no arguments."""
    command(now_s)


class _Answer:
    """The response to one call: sent when both its address and its content are known."""

    def __init__(self, response: Any, vehicle: str, ends_flight: bool) -> None:
        self.number = -1
        self.ends_flight = ends_flight
        self._response = response
        self._vehicle = vehicle
        self._is_known = False
        self._send: Callable[[Any], None] | None = None

    def give(self, error: str) -> None:
        """Fill in why the command failed; empty if it was obeyed."""
        self._response.success = not error
        self._response.message = f'{self._vehicle}: {error}' if error else ''
        self._is_known = True
        self._send_if_ready()

    def address(self, send: Callable[[Any], None]) -> None:
        """Give the function that sends the response."""
        self._send = send
        self._send_if_ready()

    def _send_if_ready(self) -> None:
        if self._is_known and self._send is not None:
            self._send(self._response)
