# SPDX-License-Identifier: Apache-2.0
"""The command services of a simulated vehicle."""

from collections.abc import Callable
from typing import Any

from rocsafe_ros import topics
from rocsafe_ros.lease_server_node import LeaseServer
from rocsafe_ros.vehicle_scope import VehicleScopeNode
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.rav.rav import Rav


class CommandServices:
    """Services: hold, return_home and land, always taken; with the lease resume.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    rav
        The vehicle.
    lease
        Judges who may give orders.
    on_command
        Called after the vehicle got a command.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        rav: Rav,
        lease: LeaseServer,
        on_command: Callable[[], None],
    ) -> None:
        self._rav = rav
        self._on_command = on_command
        vehicle = rav.vehicle
        for spec, command in (
            (topics.HOLD, vehicle.hold),
            (topics.RETURN_HOME, vehicle.return_home),
            (topics.LAND, vehicle.land),
        ):
            node.create_service(spec.call_type, spec.name, self._plain(command))
        lease.serve(topics.RESUME, self._plain(vehicle.resume))

    def _plain(self, command: Callable[[], None]) -> Callable[[Any, Any], Any]:
        return self._answered(lambda _request: command())

    def _answered(self, command: Callable[[Any], None]) -> Callable[[Any, Any], Any]:
        """Return the callback of a service that commands the vehicle."""

        def on_call(request: Any, response: Any) -> Any:
            try:
                command(request)
            except (CommandRefusedError, ValueError) as refusal:
                response.message = f'{self._rav.parts.name}: {refusal}'
                return response
            self._on_command()
            response.success = True
            return response

        return on_call
