# SPDX-License-Identifier: Apache-2.0
"""A camera as it hangs on a vehicle: where it looks, and what it then takes."""

from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import rotation_body_from_optical, rotation_enu_from_body
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.cameras.camera import Camera, Truth
from rocsafe_scene.optics.motion import (
    CameraMotion,
    Rates,
    motion_between,
    pixel_rates,
    plane_depth_m,
)
from rocsafe_scene.optics.optics import Optics
from rocsafe_scene.painting.canvas import Image
from rocsafe_sim.cameras.camera_settings import CameraSettings
from rocsafe_sim.cameras.gimbal import Direction, Gimbal


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
    rotation_enu_from_optical: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class Stand:
    """How a vehicle is at a moment: its camera's place, metres, and its attitude."""

    position_enu: Enu
    attitude: Attitude


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exposure:
    """A picture to be taken.

    Attributes
    ----------
    time_ns : simulated, of its middle row.
    stand : of the vehicle then.
    around : of the vehicle half of `MountedCamera.span_ns` earlier and later.
    rng : of the sensor's noise.
    is_quick : for a stream, whose pictures need not be as fine.
    """

    time_ns: int
    stand: Stand
    around: tuple[Stand, Stand]
    rng: np.random.Generator
    is_quick: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraModel:
    """What cameras of all vehicles of a process share.

    Attributes
    ----------
    settings : of them.
    camera : that draws, by the lens `settings.drawn_lens`.
    optics : that makes photographs of what is drawn; None: they are as drawn.
    """

    settings: CameraSettings
    camera: Camera
    optics: Optics | None = None


class MountedCamera:
    """One camera of one vehicle."""

    def __init__(self, model: CameraModel) -> None:
        self.model = model
        settings = model.settings
        self.gimbal = Gimbal(settings.limits, settings.direction) if settings.gimbal else None

    @property
    def settings(self) -> CameraSettings:
        """Of it."""
        return self.model.settings

    @property
    def name(self) -> str:
        """Of the camera."""
        return self.settings.name

    @property
    def span_ns(self) -> int:
        """Time over which motion shows in a picture; 0 if it does not."""
        effects = self.settings.effects
        return round(NS_PER_S * max(effects.shutter_s, effects.readout_s))

    def direction(self, time_ns: int) -> Direction:
        """Return where it looks from the vehicle at a time."""
        return self.gimbal.direction(time_ns) if self.gimbal else self.settings.direction

    def held(self, attitude: Attitude) -> Attitude:
        """Return how it is held by a vehicle of an attitude: a gimbal keeps it level."""
        return Attitude(yaw_rad=attitude.yaw_rad) if self.gimbal else attitude

    def rotation(self, held: Attitude, time_ns: int) -> FloatArray:
        """Return the rotation (3, 3) from the optical frame to east, north, up at a time."""
        body = rotation_enu_from_body(held.yaw_rad, held.pitch_rad, held.roll_rad)
        looks = self.direction(time_ns)
        return np.asarray(body @ rotation_body_from_optical(looks.pitch_rad, looks.yaw_rad))

    def take(self, exposure: Exposure) -> Picture:
        """Return what it takes.

        Raises
        ------
        ViewError: if it sees what cannot be drawn.
        """
        place, time_ns = exposure.stand.position_enu, exposure.time_ns
        rotation = self.rotation(self.held(exposure.stand.attitude), time_ns)
        camera, optics = self.model.camera, self.model.optics
        image = camera.photograph(place, rotation, time_ns, is_quick=exposure.is_quick)
        truth = camera.truth
        if optics is not None:
            rates = self._rates(exposure, rotation, truth)
            image = optics.develop(image, rates, exposure.rng)
            truth = None if truth is None else optics.truth(truth, rates)
        return Picture(
            camera=self.name,
            time_ns=time_ns,
            image=image,
            truth=truth,
            position_enu=place,
            rotation_enu_from_optical=rotation,
        )

    def _rates(
        self, exposure: Exposure, rotation: FloatArray, truth: Truth | None
    ) -> Rates | None:
        """Return how fast what each drawn pixel shows moves; None if nothing does."""
        if not self.span_ns:
            return None
        motion = self._motion(exposure)
        if motion.is_none:
            return None
        lens = self.settings.drawn_lens
        if truth is None:
            height_m = exposure.stand.position_enu[2]
            return pixel_rates(lens, plane_depth_m(lens, height_m, rotation), motion)
        return pixel_rates(lens, truth.depth_m, motion)

    def _motion(self, exposure: Exposure) -> CameraMotion:
        half_ns, (before, after) = self.span_ns // 2, exposure.around
        early, late = (
            self.rotation(self.held(stand.attitude), exposure.time_ns + shift_ns)
            for stand, shift_ns in ((before, -half_ns), (after, half_ns))
        )
        places = (before.position_enu, after.position_enu)
        return motion_between(places, (early, late), self.span_ns / NS_PER_S)
