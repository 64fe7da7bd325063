# SPDX-License-Identifier: Apache-2.0
"""The return that too strong a wind calls for, where the options ask for it."""

import math
from contextlib import suppress

from rocsafe_mavlink.drone.commands import DroneCommands
from rocsafe_mavlink.errors import CommandRefusedError

# A return that was refused is ordered again after this time.
ASK_AGAIN_S = 10.0


class WindReturn:
    """Calls a vehicle home once a while until it obeys."""

    def __init__(self, commands: DroneCommands) -> None:
        self._commands = commands
        self._number = -1
        self._asked_s = -math.inf
        self._is_done = False

    def step(self, now_s: float, *, is_advised: bool, is_in_air: bool) -> bool:
        """Call the vehicle home if that is advised; return whether it has just obeyed."""
        commands = self._commands
        has_obeyed = self._number >= 0 and commands.outcome(self._number) == ''
        if has_obeyed:
            self._number, self._is_done = -1, True
        if not is_advised:
            self._is_done = self._is_done and is_in_air
            return has_obeyed
        # An order of a person is not cut short.
        is_ordered = commands.outcome(commands.count) is None
        if not (is_ordered or self._is_done or now_s - self._asked_s < ASK_AGAIN_S):
            self._asked_s = now_s
            with suppress(CommandRefusedError):
                commands.return_home(now_s)
                self._number = commands.count
        return has_obeyed
