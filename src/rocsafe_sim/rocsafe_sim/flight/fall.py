# SPDX-License-Identifier: Apache-2.0
"""Free fall of a vehicle without motors, vertical and without drag."""

import math
from collections.abc import Iterator

from rocsafe_sim.flight.segment import FlightPose, Mode, Segment, standing
from rocsafe_sim.flight.timeline import ShotTime

GRAVITY_MPS2 = 9.80665


class Fall:
    """A fall to the ground, with the interface of a `Timeline`.

    Parameters
    ----------
    start
        Pose at time 0; its velocity does not count.
    ground_up_m
        Height of the ground, metres.
    """

    def __init__(self, start: FlightPose, ground_up_m: float) -> None:
        self._start = start
        self._height_m = max(0.0, start.position_enu[2] - ground_up_m)
        self.distance_m = 0.0

    @property
    def duration_s(self) -> float:
        """Duration of the fall, seconds."""
        return math.sqrt(2.0 * self._height_m / GRAVITY_MPS2)

    @property
    def stands_from_s(self) -> float:
        """Begin of a stand without end: none."""
        return math.inf

    def pose(self, elapsed_s: float) -> FlightPose:
        """Return the pose at a time."""
        east, north, up = self._start.position_enu
        if elapsed_s >= self.duration_s:
            return standing((east, north, up - self._height_m), self._start.yaw_rad)
        return FlightPose(
            position_enu=(east, north, up - 0.5 * GRAVITY_MPS2 * elapsed_s**2),
            velocity_enu=(0.0, 0.0, -GRAVITY_MPS2 * elapsed_s),
            yaw_rad=self._start.yaw_rad,
        )

    def segment(self, _elapsed_s: float) -> Segment:
        """Return the only segment, that of the fall."""
        yaw = self._start.yaw_rad
        return Segment(
            mode=Mode.FALLING, begin_s=0.0, end_s=self.duration_s, yaw_start_rad=yaw,
            yaw_end_rad=yaw,
        )  # fmt: skip

    def progress_m(self, _elapsed_s: float) -> float:
        """Return the horizontal distance flown: none."""
        return 0.0

    def used_j(self, _elapsed_s: float) -> float:
        """Return the energy that the motors have used: none."""
        return 0.0

    def power_w(self, _elapsed_s: float) -> float:
        """Return the power of the motors: none."""
        return 0.0

    def shots(self) -> Iterator[ShotTime]:
        """Yield no photographs."""
        return iter(())

    def first_start_s(self, *_modes: Mode) -> float:
        """Return 0: the vehicle descends from the start."""
        return 0.0
