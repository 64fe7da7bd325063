# SPDX-License-Identifier: Apache-2.0
"""Renderers of scenes, and a camera that draws at a higher resolution and scales down."""

from datetime import datetime
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.engine.renderer import Renderer, RendererCamera
from rocsafe_scene.engine.software_renderer import SoftwareRenderer, SoftwareRendererCamera
from rocsafe_scene.errors import SceneError
from rocsafe_scene.graphics.pipe import open_pipe
from rocsafe_scene.graphics.rendering import Purpose, Rendering
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.building import build
from rocsafe_scene.scene.description import SceneDescription
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.scene.sunlight import lighting, sun_direction

LARGEST_SIDE_PX = 8192
AnyRenderer = Renderer | SoftwareRenderer
_AnyCamera = RendererCamera | SoftwareRendererCamera


def open_renderer(
    environment: Environment, description: SceneDescription, time: datetime | None = None
) -> AnyRenderer:
    """Return a renderer of `environment`, lit as `description` says, at `time` if given.

    Raises
    ------
    EngineError
        If this machine has nothing to draw with.
    """
    light, place = description.light, description.place
    direction = sun_direction(time or light.time, place.latitude_deg, place.longitude_deg)
    sunlight = lighting(direction, light.weather)
    if open_pipe().is_degraded:
        return SoftwareRenderer(environment, sunlight)
    return Renderer(environment, sunlight)


def open_scene(
    description: SceneDescription, origin: GeoPosition | None, cache: Path | None
) -> AnyRenderer:
    """Return a renderer of a scene, see `build`.

    Raises
    ------
    SceneError, EngineError
        If the scene cannot be built or drawn; one line.
    """
    return open_renderer(build(description, origin=origin, cache=cache), description)


class OversampledCamera:
    """A camera whose image is drawn larger and scaled down, which smooths edges and detail.

    Depth and labels are drawn at the size of the image, so that they stay exact.

    Parameters
    ----------
    renderer
        Renderer of the scene.
    lens
        Intrinsics of the images.
    oversampling
        1 draws once, 2 draws four times the pixels.

    Raises
    ------
    SceneError
        If the oversampled image would be too large.
    """

    def __init__(self, renderer: AnyRenderer, lens: PinholeCamera, oversampling: int = 2) -> None:
        side = oversampling * max(lens.image_width_px, lens.image_height_px)
        if not 1 <= oversampling <= 4 or side > LARGEST_SIDE_PX:
            raise SceneError(
                f'oversampling is {oversampling}, a side of {side} px: must be 1 to 4, with sides '
                f'of {LARGEST_SIDE_PX} px at most'
            )
        self.lens = lens
        self._renderer, self._oversampling = renderer, oversampling
        self._pair: tuple[_AnyCamera, _AnyCamera] | None = None
        if oversampling > 1:
            self._pair = (
                renderer.camera(self._large(lens), Purpose.IMAGE),
                renderer.camera(lens, Purpose.TRUTH),
            )

    def expose_once(self, position_enu: Floats, rotation_enu_from_optical: Floats) -> Rendering:
        """Return what is seen from a pose, drawn once; see `RendererCamera.expose`."""
        return self._plain.expose(position_enu, rotation_enu_from_optical)

    def _large(self, lens: PinholeCamera) -> PinholeCamera:
        width_px, height_px = (
            self._oversampling * side for side in (lens.image_width_px, lens.image_height_px)
        )
        return PinholeCamera(lens.horizontal_fov_rad, width_px, height_px)

    def look_through(self, lens: PinholeCamera) -> None:
        """Use another lens, of the same image size."""
        if lens == self.lens:
            return
        self.lens = lens
        if self._pair is not None:
            self._pair[0].look_through(self._large(lens))
            self._pair[1].look_through(lens)
        if '_plain' in self.__dict__:
            self._plain.look_through(lens)

    def close(self) -> None:
        """Release the buffers."""
        for camera in (self.__dict__.pop('_plain', None), *(self._pair or ())):
            if camera is not None:
                camera.close()
        self._pair = None

    @cached_property
    def _plain(self) -> _AnyCamera:
        return self._renderer.camera(self.lens)

    def expose(self, position_enu: Floats, rotation_enu_from_optical: Floats) -> Rendering:
        """Return what is seen from a pose, see `RendererCamera.expose`."""
        if self._pair is None:
            return self.expose_once(position_enu, rotation_enu_from_optical)
        for_image, for_truth = self._pair
        # Labels must show the same leaves as the image.
        for_truth.resolve(for_image.lens.focal_px)
        frame = for_truth.expose(position_enu, rotation_enu_from_optical)
        large = for_image.expose(position_enu, rotation_enu_from_optical)
        size = (self.lens.image_width_px, self.lens.image_height_px)
        image = cv2.resize(large.image, size, interpolation=cv2.INTER_AREA)
        return Rendering(
            image=np.asarray(image),
            depth_m=frame.depth_m,
            numbers=frame.numbers,
            classes=frame.classes,
            normals=frame.normals,
        )
