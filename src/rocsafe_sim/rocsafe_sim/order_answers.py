# SPDX-License-Identifier: Apache-2.0
"""Callbacks of the services by which simulated vehicles get orders."""

from collections.abc import Callable
from typing import Any

from rocsafe_sim.errors import CommandRefusedError

Answer = Callable[[Any, Any], Any]


class OrderAnswers:
    """Makes callbacks that command a vehicle and answer with success, or its refusal in words.

    Parameters
    ----------
    name
        Name of the vehicle, which begins each refusal.
    on_command
        Called after the vehicle got a command.
    """

    def __init__(self, name: str, on_command: Callable[[], None]) -> None:
        self._name, self._on_command = name, on_command

    def plain(self, command: Callable[[], None]) -> Answer:
        """Return the callback of a service whose request says nothing more."""
        return self.to(lambda _request: command())

    def to(self, command: Callable[[Any], None]) -> Answer:
        """Return the callback of a service; `command` is given the request."""

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
