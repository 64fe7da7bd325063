# SPDX-License-Identifier: Apache-2.0
"""The camera of simulated vehicles that looks into a scene."""

import json
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.cameras.camera import Truth
from rocsafe_scene.engine.oversampled_camera import OversampledCamera, open_renderer
from rocsafe_scene.graphics.rendering import Rendering
from rocsafe_scene.mesh.classes import CLASSES
from rocsafe_scene.painting.canvas import Image
from rocsafe_scene.scene.building import build
from rocsafe_scene.scene.environment import GROUND_NUMBER, SKY_NUMBER, SceneObject
from rocsafe_scene.scene.scene_file import read_scene

# Far above the numbers of things; 65535 stays free, which stands for what 16 bits cannot hold.
GROUND_NUMBERS = 65_279


@dataclass(frozen=True, slots=True, kw_only=True)
class EngineRequest:
    """Which scene cameras are to look at.

    Attributes
    ----------
    scene_file : path of the scene.
    seed : of all that is random in it.
    origin : of the mission.
    start_ns : time of the mission's start: of the sun, and from which things move; 0 unknown.
    cache : folder of painted ground.
    """

    scene_file: Path
    seed: int
    origin: GeoPosition
    start_ns: int
    cache: Path | None


class EngineScene:
    """A scene as drawn; all cameras of a process look at the same.

    Raises
    ------
    SceneError, EngineError: one line.
    """

    def __init__(self, request: EngineRequest) -> None:
        description = read_scene(request.scene_file)
        self.environment = build(description, request.seed, request.origin, request.cache)
        self.label_table = label_table(self.environment.objects)
        self.renderer = open_renderer(self.environment, description, _sun_time(request.start_ns))
        self._start_ns = request.start_ns

    def set_time(self, time_ns: int) -> None:
        """Put what moves where it is at a simulated time."""
        self.renderer.set_time(max(0, time_ns - self._start_ns) / NS_PER_S)


class EngineCamera:
    """Photographs a scene; vehicles may share it.

    Parameters
    ----------
    scene : to look at.
    lens : of the camera.
    oversampling : 1 to 4, see `OversampledCamera`.

    Raises
    ------
    SceneError, EngineError: one line.
    """

    def __init__(self, scene: EngineScene, lens: PinholeCamera, oversampling: int) -> None:
        self.lens = lens
        self.truth: Truth | None = None
        self._scene = scene
        self._camera = OversampledCamera(scene.renderer, lens, oversampling)

    @property
    def remark(self) -> str:
        """What drew the pictures, where that is less than it should be."""
        pipe = self._scene.renderer.pipe
        return f'drawn by {pipe.renderer}' if pipe.is_degraded else ''

    def label_table(self) -> str:
        """Return names, classes and colours of the instances as JSON."""
        return self._scene.label_table

    def photograph(
        self,
        position_enu: Enu,
        rotation_enu_from_optical: FloatArray,
        time_ns: int = 0,
        *,
        is_quick: bool = False,
    ) -> Image:
        """Return the picture seen from a pose at a time: blue, green, red."""
        self._scene.set_time(time_ns)
        expose = self._camera.expose_once if is_quick else self._camera.expose
        frame = expose(np.array(position_enu), rotation_enu_from_optical)
        self.truth = Truth(depth_m=frame.depth_m, numbers=reported_numbers(frame))
        return frame.image


def _sun_time(start_ns: int) -> datetime | None:
    return datetime.fromtimestamp(start_ns / NS_PER_S, timezone.utc) if start_ns else None


def reported_numbers(frame: Rendering) -> NDArray[np.uint32]:
    """Return the instances of a frame, the ground told apart by what it is: road, grass, water."""
    ground = GROUND_NUMBERS + frame.classes.astype(np.uint32)
    return np.where(frame.numbers == GROUND_NUMBER, ground, frame.numbers)


def label_table(objects: tuple[SceneObject, ...]) -> str:
    """Return the instances as JSON: number, name, class and colour (red, green, blue) of each.

    Ground of each class has a number of its own, that of the class from 65279 on.
    """
    rows = [(SKY_NUMBER, 'sky', 'sky')]
    rows += [(thing.number, thing.name, thing.label) for thing in objects]
    rows += [
        (GROUND_NUMBERS + label.number, 'ground', label.name)
        for label in CLASSES.values()
        if label.number != SKY_NUMBER
    ]
    keys = ('number', 'name', 'class', 'colour')
    return json.dumps(
        [dict(zip(keys, (*row, CLASSES[row[2]].colour), strict=True)) for row in rows]
    )
