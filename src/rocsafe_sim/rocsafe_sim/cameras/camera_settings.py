# SPDX-License-Identifier: Apache-2.0
"""Settings of the cameras of a vehicle, as the file of the parameter `cameras_file` has them."""

import math
from dataclasses import dataclass

from rocsafe_geo.limits import require_between, require_count, require_not_negative
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.optics.distortion import lens_to_draw
from rocsafe_scene.optics.effects import NO_EFFECTS, Effects
from rocsafe_sim.cameras.gimbal import Direction, GimbalLimits

FIRST_CAMERA = 'camera'
LARGEST_IMAGE_PX = 12_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings:
    """One camera of a vehicle.

    Attributes
    ----------
    name
        Name, also of its topics. The camera of the survey is called ``camera``.
    horizontal_fov_deg
        Full angle of view across the image width, degrees.
    image_width_px, image_height_px
        Size of a photograph, pixels.
    jpeg_quality
        Quality of a photograph, 1 to 100.
    oversampling
        The engine draws photographs so many times as wide and high, and averages.
    pitch_deg
        Angle of the view above the horizon, degrees: -90 is straight down. With a gimbal: until it
        gets its first command.
    yaw_deg
        Angle of the view from the nose of the vehicle, anticlockwise, degrees.
    gimbal
        Whether it hangs in a gimbal, which keeps it level and turns it on command.
    gimbal_rate_dps
        Rate at which the gimbal turns, degrees a second.
    gimbal_lowest_deg, gimbal_highest_deg
        Limits of the pitch of the gimbal, degrees.
    stream_rate_hz
        Rate of the pictures for viewers, Hz of simulated time; 0: none.
    at_viewpoints
        Whether it takes a picture at each viewpoint, too.
    effects
        Effects of lens, shutter and sensor.
    """

    name: str = FIRST_CAMERA
    horizontal_fov_deg: float = 60.0
    image_width_px: int = 640
    image_height_px: int = 480
    jpeg_quality: int = 90
    oversampling: int = 2
    pitch_deg: float = -90.0
    yaw_deg: float = 0.0
    gimbal: bool = False
    gimbal_rate_dps: float = 60.0
    gimbal_lowest_deg: float = -90.0
    gimbal_highest_deg: float = 30.0
    stream_rate_hz: float = 0.0
    at_viewpoints: bool = True
    effects: Effects = NO_EFFECTS

    def __post_init__(self) -> None:
        name = self.name
        if not (name.isascii() and name.replace('_', 'a').isalnum() and name[:1].isalpha()):
            raise ValueError(f'name is {name!r}: must be a letter, then letters, digits or _')
        require_between('horizontal_fov_deg', self.horizontal_fov_deg, 5.0, 150.0, 'deg')
        for side in ('image_width_px', 'image_height_px'):
            require_count(side, getattr(self, side), 16, 8192)
        require_count('jpeg_quality', self.jpeg_quality, 1, 100)
        require_count('oversampling', self.oversampling, 1, 4)
        require_between('pitch_deg', self.pitch_deg, -90.0, 90.0, 'deg')
        require_between('yaw_deg', self.yaw_deg, -360.0, 360.0, 'deg')
        require_not_negative('stream_rate_hz', self.stream_rate_hz)
        pixels = self.image_width_px * self.image_height_px
        if pixels > LARGEST_IMAGE_PX:
            raise ValueError(
                f'image_width_px x image_height_px is {pixels}: must be {LARGEST_IMAGE_PX} at most'
            )
        _ = self.drawn_lens
        if self.gimbal:
            _ = self.limits
            lowest, highest = self.gimbal_lowest_deg, self.gimbal_highest_deg
            require_between('pitch_deg', self.pitch_deg, lowest, highest, 'deg')

    @property
    def lens(self) -> PinholeCamera:
        """Intrinsics, without distortion."""
        fov_rad = math.radians(self.horizontal_fov_deg)
        return PinholeCamera(fov_rad, self.image_width_px, self.image_height_px)

    @property
    def drawn_lens(self) -> PinholeCamera:
        """Intrinsics of the pinhole picture of which its photograph is made."""
        return lens_to_draw(self.lens, self.effects)

    @property
    def direction(self) -> Direction:
        """Where it looks at rest."""
        return Direction(
            pitch_rad=math.radians(self.pitch_deg), yaw_rad=math.radians(self.yaw_deg)
        )

    @property
    def limits(self) -> GimbalLimits:
        """What its gimbal can do."""
        return GimbalLimits(
            rate_radps=math.radians(self.gimbal_rate_dps),
            lowest_rad=math.radians(self.gimbal_lowest_deg),
            highest_rad=math.radians(self.gimbal_highest_deg),
        )

    @property
    def steepest_view_deg(self) -> float:
        """Largest angle of any image corner from the vertical, wherever a gimbal points."""
        lens = self.drawn_lens
        right = 0.5 * lens.image_width_px / lens.focal_px
        up = 0.5 * lens.image_height_px / lens.focal_px
        pitch = math.radians(self.gimbal_highest_deg if self.gimbal else self.pitch_deg)
        # downward part of the ray through an upper corner
        down = -math.sin(pitch) - up * math.cos(pitch)
        return math.degrees(math.acos(down / math.sqrt(1.0 + right * right + up * up)))


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraRig:
    """All cameras of a vehicle.

    Attributes
    ----------
    cameras
        The first takes the photographs of the survey: it is called ``camera`` and looks straight
        down. Without one the vehicle takes none.
    """

    cameras: tuple[CameraSettings, ...] = (CameraSettings(),)

    def __post_init__(self) -> None:
        names = [camera.name for camera in self.cameras]
        if len(set(names)) < len(names):
            raise ValueError(f'cameras are called {", ".join(names)}: names must differ')
        first = self.cameras[0] if self.cameras else CameraSettings()
        if first.name != FIRST_CAMERA or first.direction != Direction():
            raise ValueError(
                f'cameras[0]: must be called {FIRST_CAMERA} and look straight down, as surveys '
                'are planned'
            )
