# SPDX-License-Identifier: Apache-2.0
"""A picture of a scene with vehicles and lines, from a place that stays or follows a vehicle."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import ImageArray
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.cameras.engine_camera import EngineRequest, EngineScene
from rocsafe_scene.engine.oversampled_camera import OversampledCamera
from rocsafe_scene.graphics.lens import looking
from rocsafe_scene.live.overlay import COLOURS, WHITE, Colour, Overlay
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.scene.moving_sun import LightOrder

# From behind and above a vehicle that is followed, metres.
BEHIND_M, ABOVE_M = 18.0, 9.0
# How far ahead the nose of a vehicle is drawn, metres, and the size of its dot.
NOSE_M, DOT_PX = 3.0, 5


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """A vehicle: name, place east, north, up, metres, and direction from east to north."""

    name: str
    place: tuple[float, float, float]
    yaw_rad: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrawnLine:
    """A line over `places`, (n, 3)."""

    places: Floats
    colour: Colour = WHITE
    width_px: int = 1


class LiveView:
    """Draws the scene of a mission. All calls must come from the thread that made it.

    Parameters
    ----------
    request
        The scene.
    lens
        Of the view.

    Raises
    ------
    SceneError, EngineError
        If the scene cannot be built or drawn; one line.
    """

    def __init__(self, request: EngineRequest, lens: PinholeCamera) -> None:
        self.lens = lens
        self._scene = EngineScene(request)
        self._camera = OversampledCamera(self._scene.renderer, lens, 1)

    def set_light(self, order: LightOrder) -> None:
        """Change sun and air.

        Raises
        ------
        EngineError
            If this machine draws without light and shadows.
        """
        self._scene.set_light(order)

    def picture(
        self, time_ns: int, pose: tuple[Floats, Floats], sights: Sequence[Sight],
        lines: Iterable[DrawnLine],
    ) -> ImageArray:  # fmt: skip
        """Return the image at a simulated time: blue, green, red."""
        self._scene.set_time(time_ns)
        frame = self._camera.expose(*pose)
        drawn = Overlay(image=frame.image.copy(), depth_m=frame.depth_m, lens=self.lens, pose=pose)
        for line in lines:
            drawn.line(line.places, line.colour, line.width_px)
        for number, sight in enumerate(sights):
            self._draw(drawn, sight, COLOURS[number % len(COLOURS)])
        return drawn.image

    def _draw(self, drawn: Overlay, sight: Sight, colour: Colour) -> None:
        place = np.array(sight.place)
        ground = self._scene.environment.terrain.height_at(place[None, :2])[0]
        drawn.line(np.array([place, [*sight.place[:2], float(ground)]]), WHITE, 1)
        ahead = np.array([math.cos(sight.yaw_rad), math.sin(sight.yaw_rad), 0.0])
        drawn.line(np.array([place, place + NOSE_M * ahead]), colour, 3)
        drawn.dots(place[None], colour, DOT_PX)
        drawn.text(place, sight.name, colour)


def pose_at(eye: Sequence[float], target: Sequence[float]) -> tuple[Floats, Floats]:
    """Return the pose of a camera at `eye` that looks at `target`; they must differ."""
    place = np.array(eye, np.float64)
    return place, looking(np.array(target, np.float64) - place)


def pose_behind(sight: Sight) -> tuple[Floats, Floats]:
    """Return the pose of a camera behind and above a vehicle."""
    east, north, up = sight.place
    back = (BEHIND_M * math.cos(sight.yaw_rad), BEHIND_M * math.sin(sight.yaw_rad))
    return pose_at((east - back[0], north - back[1], up + ABOVE_M), sight.place)
