# SPDX-License-Identifier: Apache-2.0
"""The camera of simulated vehicles that looks into a scene."""

import json
from dataclasses import dataclass, field
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_sim.camera import Truth
from rocsafe_sim.engine.renderer import Renderer
from rocsafe_sim.engine.studio import Studio, open_renderer
from rocsafe_sim.route import Enu
from rocsafe_sim.scene.building import build
from rocsafe_sim.scene.classes import CLASSES
from rocsafe_sim.scene.environment import GROUND_NUMBER, SKY_NUMBER, SceneObject
from rocsafe_sim.scene.scene_file import read_scene
from rocsafe_sim.scenery.canvas import Image

_NS_PER_S = 1e9


@dataclass(frozen=True, slots=True, kw_only=True)
class EngineRequest:
    """What the camera is to look at, and how.

    Attributes
    ----------
    scene_file : path of the scene.
    seed : of all that is random in it.
    origin : of the mission.
    start_ns : time of the mission's start: of the sun, and from which things move; 0 unknown.
    lens : of the camera.
    oversampling : 1 to 4, see `Studio`.
    cache : folder of painted ground.
    """

    scene_file: Path
    seed: int
    origin: GeoPosition
    start_ns: int
    lens: PinholeCamera
    oversampling: int
    cache: Path | None


@dataclass(slots=True)
class EngineCamera:
    """Photographs a scene; all cameras of a process may be this one.

    Raises
    ------
    SceneError, EngineError: one line.
    """

    request: EngineRequest
    truth: Truth | None = field(init=False, default=None)
    _renderer: Renderer = field(init=False)
    _studio: Studio = field(init=False)
    _table: str = field(init=False)

    def __post_init__(self) -> None:
        request = self.request
        description = read_scene(request.scene_file)
        environment = build(description, request.seed, request.origin, request.cache)
        self._table = label_table(environment.objects)
        self._renderer = open_renderer(environment, description, _sun_time(request.start_ns))
        self._studio = Studio(self._renderer, request.lens, request.oversampling)

    @property
    def lens(self) -> PinholeCamera:
        """Intrinsics."""
        return self.request.lens

    def label_table(self) -> str:
        """Return names, classes and colours of the instances as JSON."""
        return self._table

    def photograph(
        self, position_enu: Enu, rotation_enu_from_optical: NDArray[np.float64], time_ns: int = 0
    ) -> Image:
        """Return the picture seen from a pose at a time: blue, green, red."""
        self._renderer.set_time(max(0, time_ns - self.request.start_ns) / _NS_PER_S)
        frame = self._studio.expose(np.array(position_enu), rotation_enu_from_optical)
        self.truth = Truth(depth_m=frame.depth_m, numbers=frame.numbers)
        return frame.image


def _sun_time(start_ns: int) -> datetime | None:
    return datetime.fromtimestamp(start_ns / _NS_PER_S, timezone.utc) if start_ns else None


def label_table(objects: tuple[SceneObject, ...]) -> str:
    """Return the instances as JSON: number, name, class and colour (red, green, blue) of each."""
    rows = [(SKY_NUMBER, 'sky', 'sky'), (GROUND_NUMBER, 'ground', 'grass')]
    rows += [(thing.number, thing.name, thing.label) for thing in objects]
    keys = ('number', 'name', 'class', 'colour')
    return json.dumps(
        [dict(zip(keys, (*row, CLASSES[row[2]].colour), strict=True)) for row in rows]
    )
