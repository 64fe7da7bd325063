# SPDX-License-Identifier: Apache-2.0
"""Control of a vehicle in the air: by this bridge, its pilot, another station, or a failsafe.

A command is refused while somebody else has the vehicle. What counts is what the vehicle says:
its mode, its status, and the failsafes that it announces.
"""

import math
from dataclasses import dataclass, replace

from rocsafe_mavlink.autopilots.autopilot import Autopilot, Verb
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome, failsafe_of
from rocsafe_mavlink.flight.flight_signs import shown_failsafe
from rocsafe_mavlink.knowledge.telemetry import MODE_SHOWS_S, VehicleTelemetry

# Modes in which an autopilot carries out what a station commands.
COMMANDED_MODES = (Verb.MISSION, Verb.HOLD, Verb.GUIDED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Custody:
    """What is remembered of a vehicle since its motors were started.

    Attributes
    ----------
    failsafe
        First failsafe that it announced or showed; None: none.
    failsafe_s
        Steady time of the last sign of a failsafe.
    own_mode
        Custom mode to which our last command led, until the vehicle leaves it; -1: none.
    mode
        Custom mode in which it was seen last; -1: not seen armed yet.
    takeover
        Words on a change of mode that we did not command; empty if there was none, or we
        commanded a mode since.
    """

    failsafe: FlightOutcome | None = None
    failsafe_s: float = -math.inf
    own_mode: int = -1
    mode: int = -1
    takeover: str = ''

    def heard(self, text: str, now_s: float) -> 'Custody':
        """Take a text of the vehicle."""
        return self._with_failsafe(failsafe_of(text), now_s)

    def remembering(self, failsafe: FlightOutcome | None) -> 'Custody':
        """Take the failsafe that an earlier bridge noted of the flight; None: none."""
        return replace(self, failsafe=self.failsafe or failsafe)

    def obeyed(self, mode: int) -> 'Custody':
        """Note that a command of ours led to a mode."""
        return replace(self, own_mode=mode, mode=mode, takeover='')

    def seen(
        self,
        vehicle: VehicleTelemetry,
        autopilot: Autopilot,
        expected: frozenset[int],
        now_s: float,
    ) -> 'Custody':
        """Take what is known of the vehicle; `expected` are modes that our commands lead to."""
        if not vehicle.is_armed:
            return Custody()
        mode = vehicle.custom_mode
        is_ours = self.mode in (-1, mode) or mode in expected
        # A switch together with a critical status is its own, also where no text came.
        is_failing = not is_ours and vehicle.is_in_failsafe
        shown = shown_failsafe(vehicle) or (FlightOutcome.FAILSAFE_OTHER if is_failing else None)
        after = self._with_failsafe(shown, now_s)
        return replace(
            after,
            own_mode=self.own_mode if mode == self.own_mode else -1,
            mode=mode,
            takeover=self.takeover if is_ours else _takeover(autopilot, vehicle),
        )

    def refusal(
        self,
        vehicle: VehicleTelemetry,
        autopilot: Autopilot,
        now_s: float,
        *,
        is_always_taken: bool = False,
    ) -> str:
        """Return why the vehicle is not ours to command; empty if it is.

        Parameters
        ----------
        vehicle
            The vehicle as it is known now.
        autopilot
            Its kind.
        now_s
            Steady time.
        is_always_taken
            Whether the command makes a flight safer (hold, return home, land): it is refused in
            the modes of pilots and failsafes only.
        """
        if not vehicle.is_armed:
            return ''
        mode = autopilot.mode_name(vehicle.custom_mode)
        is_announced = now_s - self.failsafe_s < MODE_SHOWS_S
        if self.failsafe is not None and (is_announced or not is_always_taken):
            return f'it is not ours to command: {self.failsafe.value}, in {mode}'
        if vehicle.is_in_failsafe and not is_always_taken:
            return f'it is not ours to command: a failsafe has it, in {mode}'
        is_failing = self.failsafe is not None or vehicle.is_in_failsafe
        is_own = vehicle.custom_mode == self.own_mode and not is_failing
        if is_own or is_commanded(vehicle, autopilot):
            return ''
        return f'it is not ours to command: it is in {mode}'

    def holder(self, vehicle: VehicleTelemetry, autopilot: Autopilot) -> str:
        """Return who controls an armed vehicle instead of this bridge; empty: this bridge does.

        ``'pilot'`` is whoever switched it to a mode of its own: a remote control, or another
        station.
        """
        if not vehicle.is_armed:
            return ''
        if self.failsafe is not None or vehicle.is_in_failsafe:
            return 'failsafe'
        is_ours = vehicle.custom_mode == self.own_mode or is_commanded(vehicle, autopilot)
        return '' if is_ours else 'pilot'

    def new_master(self, vehicle: VehicleTelemetry, autopilot: Autopilot) -> str:
        """Return words on a pilot or another station that has taken the vehicle; empty: none.

        A failsafe is none, nor is a vehicle that returns or lands: autopilots do so by themselves.
        """
        by_itself = any(autopilot.is_in(vehicle, verb) for verb in (Verb.RETURN, Verb.LAND))
        return '' if by_itself or self.failsafe is not None else self.takeover

    def _with_failsafe(self, failsafe: FlightOutcome | None, now_s: float) -> 'Custody':
        if failsafe is None:
            return self
        is_new = self.failsafe is None
        return replace(
            self,
            failsafe=self.failsafe or failsafe,
            failsafe_s=now_s if is_new else self.failsafe_s,
        )


def is_commanded(vehicle: VehicleTelemetry, autopilot: Autopilot) -> bool:
    """Whether the vehicle is in a mode in which it carries out what a station commands."""
    return any(autopilot.is_in(vehicle, verb) for verb in COMMANDED_MODES)


def _takeover(autopilot: Autopilot, vehicle: VehicleTelemetry) -> str:
    mode = autopilot.mode_name(vehicle.custom_mode)
    if vehicle.is_in_failsafe:
        return f'a failsafe switched it to {mode}'
    by_itself = (Verb.HOLD, Verb.RETURN, Verb.LAND)
    if any(autopilot.is_in(vehicle, verb) for verb in by_itself):
        return f'switched to {mode} by itself, its pilot or another station'
    return f'taken over: switched to {mode} by its pilot or another station'
