# SPDX-License-Identifier: Apache-2.0
"""The blocks of a scenario's cameras, each with its keys, units, limits and defaults."""

from typing import Annotated, Any, Literal

from pydantic import Field

from rocsafe_scenario.blocks.block import Block

CameraName = Annotated[str, Field(pattern=r'^[A-Za-z][A-Za-z0-9_]*$', max_length=32)]
# The survey's camera, whose topics are /rav1/camera/...
FIRST_CAMERA = 'camera'


class EffectsBlock(Block):
    """Lens, shutter and sensor: what each makes of a picture; 0 is nothing."""

    distortion: tuple[float, ...] = Field(default=(), max_length=5)
    exposure_ev: float = Field(default=0.0, ge=-10.0, le=10.0)
    vignetting: float = Field(default=0.0, ge=0.0, le=1.0)
    full_well_e: float = Field(default=0.0, ge=0.0, le=1e6)
    read_noise_e: float = Field(default=0.0, ge=0.0, le=1e4)
    shutter_s: float = Field(default=0.0, ge=0.0, le=1.0)
    readout_s: float = Field(default=0.0, ge=0.0, le=1.0)


class MountBlock(Block):
    """How a camera hangs, what its stream is and what its lens does."""

    gimbal: bool = False
    gimbal_rate_dps: float = Field(default=60.0, gt=0.0, le=3600.0)
    gimbal_lowest_deg: float = Field(default=-90.0, ge=-90.0, le=90.0)
    gimbal_highest_deg: float = Field(default=30.0, ge=-90.0, le=90.0)
    stream_rate_hz: float = Field(default=0.0, ge=0.0, le=1000.0)
    effects: EffectsBlock = EffectsBlock()


class CameraBlock(MountBlock):
    """The camera of every vehicle for the survey: it looks straight down.

    `backend` flat photographs `ground`: level, with the photograph of the scenario's scene, or a
    GeoTIFF. `backend` engine looks into the scene of `scene_file`, by default
    ``../scenes/<scene>.yaml`` from the scenario's file. With `backend` none simulated vehicles
    visit the viewpoints without a camera: no photographs, no map.
    """

    backend: Literal['flat', 'engine', 'none'] = 'flat'
    scene_file: str = ''
    oversampling: int = Field(default=2, ge=1, le=4)
    horizontal_fov_deg: float = Field(default=60.0, ge=5.0, le=150.0)
    image_width_px: int = Field(default=640, ge=16, le=8192)
    image_height_px: int = Field(default=480, ge=16, le=8192)
    jpeg_quality: int = Field(default=90, ge=1, le=100)
    ground: str = 'scene'


class OtherCameraBlock(MountBlock):
    """A further camera of every vehicle; what is left out is as of the survey's.

    `pitch_deg` of the view above the horizon, `yaw_deg` from the nose anticlockwise.
    """

    name: CameraName
    pitch_deg: float = Field(default=-45.0, ge=-90.0, le=90.0)
    yaw_deg: float = Field(default=0.0, ge=-360.0, le=360.0)
    at_viewpoints: bool = True
    oversampling: int | None = Field(default=None, ge=1, le=4)
    horizontal_fov_deg: float | None = Field(default=None, ge=5.0, le=150.0)
    image_width_px: int | None = Field(default=None, ge=16, le=8192)
    image_height_px: int | None = Field(default=None, ge=16, le=8192)
    jpeg_quality: int | None = Field(default=None, ge=1, le=100)


def camera_parameters(camera: CameraBlock, others: tuple[OtherCameraBlock, ...]) -> dict[str, Any]:
    """Return the parameters of the cameras of a simulated vehicle, see docs/cameras.md."""
    picture = camera.model_dump(include=_OF_THE_PICTURE)
    first = {'name': FIRST_CAMERA, **picture, **camera.model_dump(include=_OF_THE_MOUNT)}
    further = [{**picture, **other.model_dump(exclude_none=True)} for other in others]
    return {
        **backend_parameters(camera),
        'cameras_file': {'cameras': [] if camera.backend == 'none' else [first, *further]},
    }


def backend_parameters(camera: CameraBlock) -> dict[str, Any]:
    """Return the parameters of what the cameras look at."""
    return {
        'camera_backend': 'engine' if camera.backend == 'engine' else 'flat',
        'scene_file': camera.scene_file,
        'ground': camera.ground,
    }


_OF_THE_MOUNT = set(MountBlock.model_fields)
# Settings that a further camera takes from the survey camera unless it names its own.
_OF_THE_PICTURE = {
    'horizontal_fov_deg', 'image_width_px', 'image_height_px', 'jpeg_quality', 'oversampling'
}  # fmt: skip
