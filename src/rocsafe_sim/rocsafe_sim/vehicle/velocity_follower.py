# SPDX-License-Identifier: Apache-2.0
"""A vehicle that follows velocities of a stream, and stands where the stream stops."""

import math
from typing import Final

from rocsafe_geo.limits import require_between
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.commands import Command
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.free_vehicle import FreeVehicle

LONGEST_DEADLINE_S: Final = 5.0
_IN_THE_AIR = (Mode.TAKING_OFF, Mode.FLYING, Mode.HOLDING, Mode.RETURNING)


class VelocityFollower:
    """Turns velocities into orders, each of which ends by itself at the deadline.

    It ends as soon as the vehicle follows any command but its own last one: another order, or a
    failsafe of the vehicle.

    Parameters
    ----------
    vehicle
        The vehicle in the air.
    deadline_s
        Time without a velocity after which it stops, up to 5 s.

    Raises
    ------
    CommandRefusedError
        If the vehicle is on the ground or landing.
    ValueError
        If the deadline is out of its range.
    """

    def __init__(self, vehicle: FreeVehicle, deadline_s: float) -> None:
        require_between('duration_s', deadline_s, 0.05, LONGEST_DEADLINE_S, 's')
        if vehicle.mode not in _IN_THE_AIR:
            raise CommandRefusedError(f'cannot follow velocities: {vehicle.mode.value}')
        self._vehicle, self._deadline_s = vehicle, deadline_s
        vehicle.fly_at((0.0, 0.0, 0.0), deadline_s)
        self._own = self._command

    @property
    def is_over(self) -> bool:
        """Whether the vehicle follows another command now."""
        return self._command is not self._own

    def follow(
        self, velocity: Enu, turn_rate_radps: float, stamp_ns: int, *, is_of_body: bool
    ) -> None:
        """Fly at a velocity until the deadline.

        Parameters
        ----------
        velocity
            East, north, up; or ahead, left, up with `is_of_body`, metres per second.
        turn_rate_radps
            Yaw rate, anticlockwise from above.
        stamp_ns
            Simulated time at which it was sent; 0: now.

        Raises
        ------
        CommandRefusedError
            If the message is older than the deadline, or the order is refused as `fly_at` refuses
            it. The velocity before stays in force until its own deadline.
        ValueError
            If a value is no number or out of its range; as before.
        """
        vehicle = self._vehicle
        age_s = (vehicle.time_ns - stamp_ns) / NS_PER_S if stamp_ns else 0.0
        if abs(age_s) > self._deadline_s:
            side = 'old' if age_s > 0.0 else 'ahead of simulated time'
            raise CommandRefusedError(
                f'a velocity is {abs(age_s):.3g} s {side}: must be {self._deadline_s:g} s at most;'
                ' a stamp of 0 stands for now'
            )
        if is_of_body:
            velocity = _turned(velocity, vehicle.pose_at(vehicle.time_ns).yaw_rad)
        vehicle.fly_at(velocity, self._deadline_s, turn_rate_radps)
        self._own = self._command

    @property
    def _command(self) -> Command | None:
        return None if self._vehicle.flight is None else self._vehicle.flight.command


def _turned(velocity: Enu, yaw_rad: float) -> Enu:
    ahead, left, up = velocity
    cosine, sine = math.cos(yaw_rad), math.sin(yaw_rad)
    return ahead * cosine - left * sine, ahead * sine + left * cosine, up
