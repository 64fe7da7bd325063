# SPDX-License-Identifier: Apache-2.0
"""Callbacks of the services by which simulated vehicles get orders."""

from collections.abc import Callable
from typing import Any

from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.vehicle_interface.route_goals_node import RouteGoals

Answer = Callable[[Any, Any], Any]


class OrderAnswers:
    """Makes callbacks that command a vehicle and answer with success, or its refusal in words.

    Parameters
    ----------
    name
        Name of the vehicle, which begins each refusal.
    on_command
        Called after the vehicle got a command.
    goals
        Goals of its routes. They know whether the vehicle was stepped: an order before that would
        count from time 0, and the first step would let decades pass in it.
    """

    def __init__(
        self,
        name: str,
        on_command: Callable[[], None],
        goals: RouteGoals,
    ) -> None:
        self._name, self._on_command, self._goals = name, on_command, goals

    def to_end(self, command: Callable[[], None]) -> Answer:
        """Return the callback of a service that ends a movement: it is taken at any time."""

        def end(_request: Any) -> None:
            self._goals.withdraw_early()
            command()

        return self._answer(end)

    def to(self, command: Callable[[Any], None]) -> Answer:
        """Return the callback of any other service; `command` is given the request."""

        def begin(request: Any) -> None:
            if not self._goals.has_time:
                raise CommandRefusedError('its time has not begun')
            command(request)

        return self._answer(begin)

    def _answer(self, command: Callable[[Any], None]) -> Answer:
        def on_call(request: Any, response: Any) -> Any:
            try:
                command(request)
            except (CommandRefusedError, ValueError) as refusal:
                response.message = f'{self._name}: {refusal}'
                return response
            self._on_command()
            response.success = True
            return response

        return on_call
