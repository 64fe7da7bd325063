# SPDX-License-Identifier: Apache-2.0
"""A camera mounted on a vehicle, and the images it takes."""

from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray, ImageArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import PinholeCamera, rotation_body_from_optical, rotation_enu_from_body
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
from rocsafe_sim.cameras.camera_settings import CameraSettings
from rocsafe_sim.cameras.gimbal import Direction, Gimbal


@dataclass(frozen=True, slots=True, kw_only=True)
class Attitude:
    """Attitude of a vehicle, rad, by REP 103: yaw, then pitch (positive: nose down), then roll."""

    yaw_rad: float
    pitch_rad: float = 0.0
    roll_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraPicture:
    """An image with its pose and true depth and labels.

    Attributes
    ----------
    settings
        Settings of the camera with which it was taken.
    time_ns
        Simulated time of the exposure.
    image
        Pixels, blue, green, red, (height, width, 3).
    truth
        Depth and label of each pixel; None if the camera does not know them.
    position_enu
        True place of the camera, metres.
    rotation_enu_from_optical
        True rotation, (3, 3).
    """

    settings: CameraSettings
    time_ns: int
    image: ImageArray
    truth: Truth | None
    position_enu: Enu
    rotation_enu_from_optical: FloatArray

    @property
    def camera(self) -> str:
        """Name of the camera."""
        return self.settings.name


@dataclass(frozen=True, slots=True, kw_only=True)
class VehiclePose:
    """Place of the cameras of a vehicle, metres, and its attitude at one time."""

    position_enu: Enu
    attitude: Attitude


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Exposure:
    """Request for an image.

    Attributes
    ----------
    time_ns
        Simulated time of its middle row.
    stand
        Pose of the vehicle at that time.
    around
        Poses of the vehicle half of `MountedCamera.span_ns` earlier and later.
    rng
        Generator of the sensor's noise.
    is_quick
        Whether it is for a stream or a look: drawn without oversampling, in their field of view.
    """

    time_ns: int
    stand: VehiclePose
    around: tuple[VehiclePose, VehiclePose]
    rng: np.random.Generator
    is_quick: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CameraModel:
    """The part of a camera that all vehicles of a process share.

    Attributes
    ----------
    settings
        Settings of the camera.
    camera
        Draws images through the lens `settings.drawn_lens`.
    optics
        Makes a photograph of a drawn image; None: the photograph is the drawn image.
    """

    settings: CameraSettings
    camera: Camera
    optics: Optics | None = None


def optics_of(settings: CameraSettings) -> Optics | None:
    """Return the optics of a camera; None if it has no effects."""
    return None if settings.effects.are_none else Optics(settings.lens, settings.effects)


class MountedCamera:
    """One camera of one vehicle."""

    def __init__(self, model: CameraModel) -> None:
        self.model = self._looks = model
        settings = model.settings
        self.gimbal = Gimbal(settings.limits, settings.direction) if settings.gimbal else None

    @property
    def settings(self) -> CameraSettings:
        """Settings of the camera."""
        return self.model.settings

    @property
    def name(self) -> str:
        """Name of the camera."""
        return self.settings.name

    @property
    def span_ns(self) -> int:
        """Time over which motion affects an image, nanoseconds; 0 if it has no effect."""
        effects = self.settings.effects
        return round(NS_PER_S * max(effects.shutter_s, effects.readout_s))

    def direction(self, time_ns: int) -> Direction:
        """Return its direction from the vehicle at a time."""
        return self.gimbal.direction(time_ns) if self.gimbal else self.settings.direction

    def held(self, attitude: Attitude) -> Attitude:
        """Return the attitude of its mount on a vehicle; a gimbal keeps it level."""
        return Attitude(yaw_rad=attitude.yaw_rad) if self.gimbal else attitude

    def rotation(self, held: Attitude, time_ns: int) -> FloatArray:
        """Return the rotation (3, 3) from the optical frame to east, north, up at a time."""
        body = rotation_enu_from_body(held.yaw_rad, held.pitch_rad, held.roll_rad)
        looks = self.direction(time_ns)
        return np.asarray(body @ rotation_body_from_optical(looks.pitch_rad, looks.yaw_rad))

    def set_fov(self, horizontal_fov_deg: float) -> None:
        """Change the field of view of streams and looks.

        Raises
        ------
        ValueError
            If no such camera can be.
        ViewError
            If the view cannot be drawn.
        """
        settings = replace(self.settings, horizontal_fov_deg=horizontal_fov_deg)
        if settings == self._looks.settings:
            return
        model = self.model
        if settings != self.settings:
            camera = model.camera.through(settings.drawn_lens)
            model = CameraModel(settings=settings, camera=camera, optics=optics_of(settings))
        if self._looks is not self.model:
            self._looks.camera.close()
        self._looks = model

    def take(self, exposure: Exposure) -> CameraPicture:
        """Return the image of an exposure.

        Raises
        ------
        ViewError
            If the view cannot be drawn.
        """
        place, time_ns = exposure.stand.position_enu, exposure.time_ns
        rotation = self.rotation(self.held(exposure.stand.attitude), time_ns)
        model = self._looks if exposure.is_quick else self.model
        camera, optics = model.camera, model.optics
        image = camera.photograph(place, rotation, time_ns, is_quick=exposure.is_quick)
        truth = camera.truth
        if optics is not None:
            rates = self._rates(exposure, model.settings.drawn_lens, rotation, truth)
            image = optics.develop(image, rates, exposure.rng)
            truth = None if truth is None else optics.truth(truth, rates)
        return CameraPicture(
            settings=model.settings,
            time_ns=time_ns,
            image=image,
            truth=truth,
            position_enu=place,
            rotation_enu_from_optical=rotation,
        )

    def _rates(
        self,
        exposure: Exposure,
        lens: PinholeCamera,
        rotation: FloatArray,
        truth: Truth | None,
    ) -> Rates | None:
        """Return the image motion of each drawn pixel; None if nothing moves."""
        if not self.span_ns:
            return None
        motion = self._motion(exposure)
        if motion.is_none:
            return None
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
