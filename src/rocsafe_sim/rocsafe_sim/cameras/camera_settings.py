# SPDX-License-Identifier: Apache-2.0
"""Settings of one camera of a vehicle, and how they are written in a parameter."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import yaml

from rocsafe_geo.limits import require_between, require_count, require_not_negative
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.optics.distortion import lens_to_draw
from rocsafe_scene.optics.effects import NO_EFFECTS, Effects
from rocsafe_sim.cameras.gimbal import Direction, GimbalLimits

FIRST_CAMERA = 'camera'
LARGEST_IMAGE_PX = 12_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings:
    """One camera of a vehicle; the first, called camera, takes the photographs of the survey.

    Attributes
    ----------
    name : also of its topics.
    horizontal_fov_deg, image_width_px, image_height_px, jpeg_quality, oversampling : see
        `VehicleOptions`.
    pitch_deg : of the view above the horizon: -90 straight down; of a gimbal at rest.
    yaw_deg : of the view from the vehicle's nose, anticlockwise.
    gimbal : whether it hangs in a gimbal: level however the vehicle sways, and turned by orders.
    gimbal_rate_dps, gimbal_lowest_deg, gimbal_highest_deg : what the gimbal can do.
    stream_rate_hz : of its stream for viewers; 0: none.
    at_viewpoints : whether it also takes a picture at each viewpoint.
    effects : of lens and sensor.
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


def cameras_of(texts: Sequence[str], first: CameraSettings) -> tuple[CameraSettings, ...]:
    """Return the cameras that a vehicle's parameter describes.

    Parameters
    ----------
    texts : a YAML mapping for each camera, e.g. ``{name: front, pitch_deg: -30}``; the first is
        that of the survey, keys left out are those of `first`. Empty: `first` alone.
    first : the camera that the other parameters describe.

    Raises
    ------
    ValueError: naming the camera, the key, its value and the limit.
    """
    cameras = [_camera(index, text, first) for index, text in enumerate(texts)] or [first]
    if cameras[0].name != FIRST_CAMERA or cameras[0].direction != Direction():
        raise ValueError(
            f'cameras[0] is {cameras[0].name!r}: must be called {FIRST_CAMERA}, and look straight '
            'down, as surveys are planned'
        )
    names = [camera.name for camera in cameras]
    if len(set(names)) < len(names):
        raise ValueError(f'cameras are called {", ".join(names)}: names must differ')
    return tuple(cameras)


def _camera(index: int, text: str, first: CameraSettings) -> CameraSettings:
    try:
        given = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ValueError(f'cameras[{index}] is {text!r}: must be YAML') from error
    try:
        settings = _typed(CameraSettings, _mapping('it', given))
        effects = _mapping('effects', settings.pop('effects', {}))
        return replace(first, effects=Effects(**_typed(Effects, effects)), **settings)
    except ValueError as error:
        raise ValueError(f'cameras[{index}]: {error}') from error


def _mapping(key: str, given: object) -> Mapping[str, Any]:
    if isinstance(given, dict):
        return given
    raise ValueError(f'{key} is {given!r}: must be a mapping of keys to values')


def _typed(settings_type: type, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return `given` as keyword arguments of `settings_type`."""
    kinds = {each.name: each.type for each in dataclasses.fields(settings_type)}
    return {key: _value(key, value, kinds) for key, value in given.items()}


def _value(key: str, value: Any, kinds: Mapping[str, Any]) -> Any:
    if key not in kinds:
        raise ValueError(f'{key} is unknown: must be one of {", ".join(kinds)}')
    kind = kinds[key]
    if kind is Effects:
        return value
    if kind == tuple[float, ...] and isinstance(value, list):
        return tuple(value)
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(kind, type) or type(value) is not kind:
        raise ValueError(f'{key} is {value!r}: must be {getattr(kind, "__name__", kind)}')
    return value
