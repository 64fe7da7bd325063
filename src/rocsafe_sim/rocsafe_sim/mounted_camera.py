# SPDX-License-Identifier: Apache-2.0
"""A camera as it hangs on a vehicle: where it looks, and what it then takes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.pinhole import rotation_body_from_optical, rotation_enu_from_body
from rocsafe_sim.camera import Camera, Truth
from rocsafe_sim.camera_settings import CameraSettings
from rocsafe_sim.gimbal import Direction, Gimbal
from rocsafe_sim.route import Enu
from rocsafe_sim.scenery.canvas import Image


@dataclass(frozen=True, slots=True, kw_only=True)
class Attitude:
    """Of a vehicle, rad: yaw, then pitch (positive lowers the nose), then roll, after REP 103."""

    yaw_rad: float
    pitch_rad: float = 0.0
    roll_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Picture:
    """What a camera took.

    Attributes
    ----------
    camera : its name.
    time_ns : of the exposure, simulated.
    image : blue, green, red, (height, width, 3).
    truth : of each pixel; None if the camera does not know.
    position_enu : of the camera, true, metres.
    rotation_enu_from_optical : true, (3, 3).
    """

    camera: str
    time_ns: int
    image: Image
    truth: Truth | None
    position_enu: Enu
    rotation_enu_from_optical: NDArray[np.float64]


class MountedCamera:
    """One camera of one vehicle.

    Parameters
    ----------
    settings : of it.
    camera : that draws; other vehicles may use the same.
    """

    def __init__(self, settings: CameraSettings, camera: Camera) -> None:
        self.settings = settings
        self.camera = camera
        self.gimbal = Gimbal(settings.limits, settings.direction) if settings.gimbal else None

    def direction(self, time_ns: int) -> Direction:
        """Return where it looks from the vehicle at a time."""
        return self.gimbal.direction(time_ns) if self.gimbal else self.settings.direction

    def held(self, attitude: Attitude) -> Attitude:
        """Return how it is held by a vehicle of an attitude: a gimbal keeps it level."""
        return Attitude(yaw_rad=attitude.yaw_rad) if self.gimbal else attitude

    def rotation(self, held: Attitude, time_ns: int) -> NDArray[np.float64]:
        """Return the rotation (3, 3) from the optical frame to east, north, up at a time."""
        body = rotation_enu_from_body(held.yaw_rad, held.pitch_rad, held.roll_rad)
        looks = self.direction(time_ns)
        return np.asarray(body @ rotation_body_from_optical(looks.pitch_rad, looks.yaw_rad))

    def take(
        self, position_enu: Enu, attitude: Attitude, time_ns: int, *, is_quick: bool = False
    ) -> Picture:
        """Return what it sees from a vehicle at a time.

        Raises
        ------
        SimError: if it sees what cannot be drawn.
        """
        rotation = self.rotation(self.held(attitude), time_ns)
        image = self.camera.photograph(position_enu, rotation, time_ns, is_quick=is_quick)
        return Picture(
            camera=self.settings.name,
            time_ns=time_ns,
            image=image,
            truth=self.camera.truth,
            position_enu=position_enu,
            rotation_enu_from_optical=rotation,
        )
