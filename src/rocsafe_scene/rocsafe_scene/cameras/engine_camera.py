# SPDX-License-Identifier: Apache-2.0
"""Cameras of simulated vehicles that see a scene of the engine."""

import json
import math
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray, ImageArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.cameras.camera import Truth
from rocsafe_scene.engine.oversampled_camera import OversampledCamera, open_renderer
from rocsafe_scene.engine.renderer import Renderer
from rocsafe_scene.errors import EngineError
from rocsafe_scene.graphics.rendering import Rendering
from rocsafe_scene.mesh.classes import CLASSES
from rocsafe_scene.scene.building import build
from rocsafe_scene.scene.environment import GROUND_NUMBER, SKY_NUMBER, SceneObject
from rocsafe_scene.scene.moving_sun import LightOrder
from rocsafe_scene.scene.scene_file import read_scene
from rocsafe_scene.scene.sunlight import Air, Lighting, lighting, sun_direction

# Ground numbers lie far above object numbers. 65535 stays free: it stands for numbers that do not
# fit into 16 bits.
GROUND_NUMBERS = 65_279


@dataclass(frozen=True, slots=True, kw_only=True)
class EngineRequest:
    """The scene that cameras look at, and when.

    Attributes
    ----------
    scene_file
        Path of the scene file.
    seed
        Seed of everything random in the scene.
    origin
        Mission origin.
    start_ns
        Start of the mission, nanoseconds since 1970; sets the sun, and objects move from then on.
        0: unknown.
    cache
        Folder in which painted ground is kept; None: it is painted anew.
    """

    scene_file: Path
    seed: int
    origin: GeoPosition
    start_ns: int
    cache: Path | None


class EngineScene:
    """A scene with its renderer, shared by all cameras of a process.

    Raises
    ------
    SceneError, EngineError
        If the scene cannot be built or drawn; one line.
    """

    def __init__(self, request: EngineRequest) -> None:
        description = read_scene(request.scene_file)
        self.environment = build(description, request.seed, request.origin, request.cache)
        self.label_table = label_table(self.environment.objects)
        self.renderer = open_renderer(self.environment, description, _sun_time(request.start_ns))
        self._start_ns = request.start_ns
        self._order = LightOrder()
        self._lit = (request.start_ns, self._order.air)

    def set_time(self, time_ns: int) -> None:
        """Move objects and the sun to their places at a simulated time, ns since 1970."""
        self.renderer.set_time(max(0, time_ns - self._start_ns) / NS_PER_S)
        sun = self._order.sun
        wanted = (self._start_ns if sun is None else sun.at(time_ns), self._order.air)
        if wanted != self._lit and isinstance(self.renderer, Renderer):
            self.renderer.relight(self._light(*wanted))
            self._lit = wanted

    def set_light(self, order: LightOrder) -> None:
        """Change sun and air from the next image on.

        Raises
        ------
        EngineError
            If this machine draws without light and shadows.
        """
        if not isinstance(self.renderer, Renderer):
            raise EngineError(
                f'the light cannot be changed: {self.renderer.pipe.renderer} draws without shadows'
            )
        self._order = order

    def _light(self, sun_ns: int, air: Air) -> Lighting:
        light, place = self.environment.description.light, self.environment.description.place
        time = _sun_time(sun_ns) or light.time
        direction = sun_direction(time, place.latitude_deg, place.longitude_deg)
        return lighting(direction, light.weather, air)


class EngineCamera:
    """A camera in a scene; vehicles may share it.

    Parameters
    ----------
    scene
        Scene that it sees.
    lens
        Intrinsics of the camera.
    oversampling
        1 to 4, see `OversampledCamera`.
    buffers
        Those of another camera, to be shared; None: its own.

    Raises
    ------
    SceneError, EngineError
        One line.
    """

    def __init__(
        self,
        scene: EngineScene,
        lens: PinholeCamera,
        oversampling: int,
        buffers: OversampledCamera | None = None,
    ) -> None:
        self.lens = lens
        self.truth: Truth | None = None
        self._scene, self._oversampling = scene, oversampling
        self._is_sharing = buffers is not None
        self._camera = buffers or OversampledCamera(scene.renderer, lens, oversampling)

    @property
    def remark(self) -> str:
        """Name of the renderer if it draws less than the full scene; else empty."""
        pipe = self._scene.renderer.pipe
        return f'drawn by {pipe.renderer}' if pipe.is_degraded else ''

    def label_table(self) -> str:
        """Return names, classes and colours of the instances as JSON."""
        return self._scene.label_table

    def set_light(self, order: LightOrder) -> None:
        """Change sun and air of the scene, also for all other cameras in it."""
        self._scene.set_light(order)

    def through(self, lens: PinholeCamera) -> 'EngineCamera':
        """Return a camera of the same scene with another lens; it shares buffers of its size."""
        old = self._camera.lens
        sizes = [(each.image_width_px, each.image_height_px) for each in (old, lens)]
        buffers = self._camera if sizes[0] == sizes[1] else None
        return EngineCamera(self._scene, lens, self._oversampling, buffers)

    def close(self) -> None:
        """Release its buffers if they are its own."""
        if not self._is_sharing:
            self._camera.close()

    def photograph(
        self,
        position_enu: Enu,
        rotation_enu_from_optical: FloatArray,
        time_ns: int = 0,
        *,
        is_quick: bool = False,
    ) -> ImageArray:
        """Return the image seen from a pose at a time: blue, green, red."""
        self._scene.set_time(time_ns)
        self._camera.look_through(self.lens)
        expose = self._camera.expose_once if is_quick else self._camera.expose
        frame = expose(np.array(position_enu), rotation_enu_from_optical)
        self.truth = Truth(depth_m=frame.depth_m, numbers=reported_numbers(frame))
        return frame.image


def _sun_time(start_ns: int) -> datetime | None:
    return datetime.fromtimestamp(start_ns / NS_PER_S, timezone.utc) if start_ns else None


def reported_numbers(frame: Rendering) -> NDArray[np.uint32]:
    """Return instance numbers, with one number for each class of ground (road, grass, water)."""
    ground = GROUND_NUMBERS + frame.classes.astype(np.uint32)
    return np.where(frame.numbers == GROUND_NUMBER, ground, frame.numbers)


def label_table(objects: tuple[SceneObject, ...]) -> str:
    """Return the instances as JSON: number, name, class and colour (red, green, blue) of each.

    Ground of class k has the number 65279 + k. Things that stand have a place, too.
    """
    rows = [_row(SKY_NUMBER, 'sky', 'sky')]
    rows += [_row(one.number, one.name, one.label) | _standing(one) for one in objects]
    rows += [
        _row(GROUND_NUMBERS + label.number, 'ground', label.name)
        for label in CLASSES.values()
        if label.number != SKY_NUMBER
    ]
    return json.dumps(rows)


def _row(number: int, name: str, label: str) -> dict[str, Any]:
    return {'number': number, 'name': name, 'class': label, 'colour': CLASSES[label].colour}


def _standing(thing: SceneObject) -> dict[str, Any]:
    """Return the middle of a thing that never moves, metres east, north, up, and its yaw, rad."""
    if thing.path is not None:
        return {}
    middle, ahead = thing.bounds.mean(axis=0), thing.pieces[0].rotation[:, 0]
    yaw_rad = math.atan2(ahead[1], ahead[0])
    return {'place': [round(part, 3) for part in middle.tolist()], 'yaw': round(yaw_rad, 4)}
