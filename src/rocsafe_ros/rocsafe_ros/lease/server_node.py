# SPDX-License-Identifier: Apache-2.0
"""The control lease of a vehicle, real or simulated, as service and topic of its node."""

import json
import os
import secrets
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rclpy.clock import Clock, ClockType
from std_msgs.msg import Header

from rocsafe_geo.storage.durable import replace_whole
from rocsafe_geo.storage.kept_file import KeptFile
from rocsafe_geo.storage.value_file import values_of
from rocsafe_interfaces.msg import Control
from rocsafe_interfaces.srv import Lease as LeaseService
from rocsafe_ros.conversions import stamp_of_ns
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import CallSpec
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.control_lease import (
    MISSION_VARIABLE,
    Lease,
    LeaseKeeper,
    LeaseRefusedError,
    server_of,
)
from rocsafe_ros.parameters import ParameterError

JOURNAL_NAME = 'lease.json'
# Period of looking whether the lease has ended.
LOOK_S = 1.0


class LeaseServer:
    """Serves lease, publishes control, and judges the orders to a vehicle.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    folder
        Keeps the lease over restarts of this process; None: nothing is kept.
    doubt
        Returns why no order can be taken now, whoever gives it; empty if it can.

    Raises
    ------
    ParameterError
        If the file of the lease is damaged.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        folder: Path | None,
        doubt: Callable[[], str] = lambda: '',
    ) -> None:
        self._node = node
        self._doubt = doubt
        self._vehicle = node.vehicle_name
        path = None if folder is None else folder / JOURNAL_NAME
        self._file = KeptFile(path, replace_whole)
        self._keeper = LeaseKeeper(self._vehicle, self._kept_lease(path), time.monotonic())
        self._was_valid = self._keeper.is_valid(time.monotonic())
        self._control = topics.create_publisher(node, topics.CONTROL)
        spec = calls.LEASE
        self._service = node.create_service(spec.call_type, spec.name, self._on_request)
        self._silence(self._service)
        node.create_timer(LOOK_S, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._publish()

    @property
    def server(self) -> str:
        """Identity of this node."""
        return self._keeper.lease.server

    @property
    def who(self) -> str:
        """Who was granted the lease last, and of which mission."""
        return self._keeper.lease.who

    def require(self, lease: str) -> None:
        """Refuse an order that does not carry the lease.

        Raises
        ------
        LeaseRefusedError
            Saying who leads the vehicle.
        """
        self._keeper.require(lease, time.monotonic())
        if why := self._doubt():
            raise LeaseRefusedError(why)

    def is_for_another(self, lease: str) -> bool:
        """Return whether an order is for another node of the same name, which answers it."""
        server = lease.partition('/')[0]
        return server not in ('', self._keeper.lease.server) and self._has_twin()

    def revoke(self, why: str) -> None:
        """Make the lease void until it is taken again."""
        before = self._keeper.lease
        self._keeper.revoke(why)
        self._note(before)

    def serve(self, spec: CallSpec, on_order: Callable[[Any, Any], Any]) -> None:
        """Serve an order, called with request and response if it carries the lease."""

        def on_call(request: Any, response: Any) -> Any:
            if self.is_for_another(request.lease):
                return None
            try:
                self.require(request.lease)
            except LeaseRefusedError as refusal:
                response.message = f'{self._vehicle}: {refusal}'
                return response
            return on_order(request, response)

        self._silence(self._node.create_service(spec.call_type, spec.name, on_call))

    def _has_twin(self) -> bool:
        return self._node.count_services(self._service.service_name) > 1

    @staticmethod
    def _silence(service: Any) -> None:
        """Let a service send nothing where its callback returns None: another node answers."""
        send = service.send_response

        def send_some(response: Any, header: Any) -> None:
            if response is not None:
                send(response, header)

        # The executors send the response by this method as soon as the callback returns.
        service.send_response = send_some

    def _on_request(self, request: Any, response: Any) -> Any:
        if request.server not in ('', self._keeper.lease.server) and self._has_twin():
            return None
        before = self._keeper.lease
        try:
            self._carry_out(request)
        except (LeaseRefusedError, ValueError) as refusal:
            response.message = f'{self._vehicle}: {refusal}'
        else:
            response.success = True
            self._note(before)
        response.control = self._message()
        return response

    def _carry_out(self, request: Any) -> None:
        keeper, now_s = self._keeper, time.monotonic()
        if request.request == LeaseService.Request.RENEW:
            keeper.renew(request.lease, request.duration_s, now_s)
        elif request.request == LeaseService.Request.RELEASE:
            keeper.release(request.lease, now_s)
        elif request.request != LeaseService.Request.TAKE:
            raise ValueError(f'request is {request.request}: must be TAKE, RENEW or RELEASE')
        elif request.server not in ('', keeper.lease.server):
            raise LeaseRefusedError('the vehicle of another mission has this name')
        else:
            asked = Lease(
                server=keeper.lease.server,
                holder=request.holder,
                mission=request.mission,
                duration_s=request.duration_s,
            )
            keeper.take(asked, now_s, takes_over=request.take_over)

    def _note(self, before: Lease) -> None:
        """Note a change of the lease on disk, log it and publish it."""
        after = self._keeper.lease
        if after != before:
            self._write(after)
        if (after.number, after.void) != (before.number, before.void):
            self._node.get_logger().info(f'{self._vehicle}: {self._keeper.text}')
        self._was_valid = self._keeper.is_valid(time.monotonic())
        self._publish()

    def _look(self) -> None:
        is_valid = self._keeper.is_valid(time.monotonic())
        if self._was_valid and not is_valid:
            self._keeper.text = f'the lease of {self._keeper.lease.who} has ended'
            self._node.get_logger().warning(f'{self._vehicle}: {self._keeper.text}')
            self._publish()
        self._was_valid = is_valid

    def _publish(self) -> None:
        self._control.publish(self._message())

    def _message(self) -> Control:
        lease, now_s = self._keeper.lease, time.monotonic()
        message = Control(
            header=Header(
                stamp=self._node.get_clock().now().to_msg(), frame_id=f'{self._vehicle}/base_link'
            ),
            vehicle=self._vehicle,
            server=lease.server,
            epoch=lease.epoch,
            text=self._keeper.text,
        )
        if self._keeper.is_valid(now_s):
            message.lease, message.holder, message.mission = (
                lease.number, lease.holder, lease.mission
            )  # fmt: skip
            left_ns = round((self._keeper.expires_s - now_s) * 1e9)
            message.expires = stamp_of_ns(time.time_ns() + left_ns)
        return message

    def _kept_lease(self, path: Path | None) -> Lease:
        """Return the lease of an earlier process of this mission, or none."""
        token = os.environ.get(MISSION_VARIABLE, '')
        server = server_of(self._vehicle, token or secrets.token_hex(16))
        if path is None or not path.exists():
            return Lease(server=server)
        try:
            kept = values_of(json.loads(path.read_bytes()), Lease, path.name)
        except ValueError as error:
            raise ParameterError(f'{path} is damaged: {error}') from error
        return Lease(server=server) if token and kept.server != server else kept

    def _write(self, lease: Lease) -> None:
        """Keep a lease over restarts; where that fails it holds until the process ends."""
        self._file.keep(json.dumps(asdict(lease)).encode())
        if self._file.fault:
            self._node.get_logger().error(f'{self._vehicle}: {self._file.fault}')
