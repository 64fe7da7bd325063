# SPDX-License-Identifier: Apache-2.0
"""The node ``fleet_verbs``: commands to all vehicles at once, also after the orchestrator's death.

The orchestrator starts it and stops it at the end of a run. If the orchestrator dies, it goes on
as long as there is a vehicle to command.
"""

import socket
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from rclpy.client import Client
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import Trigger

from rocsafe_geo.option import option
from rocsafe_interfaces.msg import Control, VehicleAnswer
from rocsafe_interfaces.srv import FleetCommand, Lease, Resume
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import CallSpec, name_of
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.process.run import is_orphan, run

# A call is answered after this time, by those who have answered.
ANSWER_S = 0.8
LOOK_S = 0.02
# An orphan without a vehicle that can be reached ends after this time.
ALONE_S = 5.0
VERBS = {
    calls.FLEET_HOLD: calls.HOLD,
    calls.FLEET_RETURN_HOME: calls.RETURN_HOME,
    calls.FLEET_LAND: calls.LAND,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetVerbsOptions:
    """Parameters of the node."""

    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles to command')
    mission: str = option('', 'mission that leads them; it may let them go on after a hold')

    def __post_init__(self) -> None:
        if not self.vehicles or len(set(self.vehicles)) < len(self.vehicles):
            raise ValueError(f'vehicles = {list(self.vehicles)}: must be one or more that differ')


class Call:
    """One call to the fleet, answered when all vehicles have answered, or it is time."""

    def __init__(self, vehicles: list[str], response: Any) -> None:
        self.answers: dict[str, VehicleAnswer] = {}
        self._vehicles = vehicles
        self._response = response
        self._until_s = time.monotonic() + ANSWER_S

    def note(self, vehicle: str, success: bool, message: str) -> None:
        """Keep the answer of a vehicle."""
        self.answers[vehicle] = VehicleAnswer(vehicle=vehicle, success=success, message=message)

    def response(self) -> Any | None:
        """Return the response if it is time, else None."""
        silent = [name for name in self._vehicles if name not in self.answers]
        if silent and time.monotonic() < self._until_s:
            return None
        for name in silent:
            self.note(name, success=False, message=f'{name}: no answer within {ANSWER_S:g} s')
            self.answers[name].is_silent = True
        self._response.answers = [self.answers[name] for name in sorted(self._vehicles)]
        self._response.success = all(answer.success for answer in self._response.answers)
        return self._response


class FleetVerbsNode(Node):
    """Serves fleet/hold, fleet/resume, fleet/return_home and fleet/land.

    Each vehicle is asked, whatever the others answer. The lease that resume needs is that of
    `mission`; where nobody leads a vehicle it is taken.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('fleet_verbs', **node_options)
        self._options = declare_options(self, FleetVerbsOptions)
        self._controls: dict[str, Control] = {}
        self._calls: list[tuple[Call, Callable[[Any], None]]] = []
        self._commands: dict[tuple[CallSpec, str], Client] = {}
        self._heard_s = time.monotonic()
        for name in self._options.vehicles:
            for spec in (*VERBS.values(), calls.RESUME, calls.LEASE):
                full = name_of(spec, name)
                self._commands[spec, name] = self.create_client(spec.call_type, full)
            on_control = partial(self._controls.__setitem__, name)
            topics.create_subscription(self, topics.CONTROL, on_control, name)
        for served, spec in VERBS.items():
            self._serve(served, partial(self._command, spec))
        self._serve(calls.FLEET_RESUME, self._resume)
        self.create_timer(LOOK_S, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    @property
    def is_needed(self) -> bool:
        """Whether a supervisor lives, or a vehicle can be reached."""
        now_s = time.monotonic()
        if not is_orphan() or any(
            self._commands[calls.HOLD, name].service_is_ready() for name in self._options.vehicles
        ):
            self._heard_s = now_s
        return now_s - self._heard_s < ALONE_S

    def _serve(self, spec: CallSpec, ask: Callable[[Call, str], None]) -> None:
        def on_call(request: FleetCommand.Request, response: Any) -> Call:
            wanted = sorted(set(request.vehicles)) or list(self._options.vehicles)
            call = Call(wanted, response)
            for name in wanted:
                if name in self._options.vehicles:
                    ask(call, name)
                else:
                    call.note(name, success=False, message=f'{name}: is not of this fleet')
            return call

        service = self.create_service(spec.call_type, spec.name, on_call)
        send = service.send_response

        def send_later(call: Call, header: Any) -> None:
            self._calls.append((call, lambda response: send(response, header)))

        # The executors send the response by this method as soon as the callback returns.
        service.send_response = send_later

    def _look(self) -> None:
        waiting, self._calls = self._calls, []
        for call, send in waiting:
            response = call.response()
            if response is None:
                self._calls.append((call, send))
            else:
                send(response)

    def _command(self, spec: CallSpec, call: Call, name: str) -> None:
        self._ask(spec, Trigger.Request(), call, name)

    def _resume(self, call: Call, name: str) -> None:
        control = self._controls.get(name)
        if control is not None and control.lease and control.mission == self._options.mission:
            self._ask(calls.RESUME, Resume.Request(lease=control.lease), call, name)
            return

        def on_lease(answer: Any) -> None:
            if answer.success:
                request = Resume.Request(lease=answer.control.lease)
                self._ask(calls.RESUME, request, call, name)
            else:
                call.note(name, success=False, message=answer.message)

        request = Lease.Request(holder=f'operator@{socket.gethostname()}')
        self._ask(calls.LEASE, request, call, name, on_lease)

    def _ask(
        self,
        spec: CallSpec,
        request: Any,
        call: Call,
        name: str,
        then: Callable[[Any], None] | None = None,
    ) -> None:
        client = self._commands[spec, name]
        if not client.service_is_ready():
            call.note(name, success=False, message=f'{name}: cannot be reached')
            return

        def on_answer(future: Any) -> None:
            answer = future.result()
            if then is not None:
                then(answer)
            else:
                call.note(name, success=answer.success, message=answer.message)

        client.call_async(request).add_done_callback(on_answer)


def main() -> int:
    """Run the node until it is asked to stop or is no longer needed."""
    return run(FleetVerbsNode, outlives=lambda node: node.is_needed)


if __name__ == '__main__':
    sys.exit(main())
