# SPDX-License-Identifier: Apache-2.0
"""Pictures of a scene as a part of what a drone observes.

The engine draws them (docs/scenes.md); what happens in an environment does not depend on them.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray
from pettingzoo.utils import BaseParallelWrapper

from rocsafe_geo.limits import require_between, require_count
from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_learning.environments.search_spaces import Observation
from rocsafe_scene.engine.oversampled_camera import AnyRenderer, open_renderer
from rocsafe_scene.ground.terrain import Terrain
from rocsafe_scene.scene.building import build
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_scene.scene.scene_file import read_scene

# The top of a picture is north.
_DOWN = rotation_enu_from_optical(math.pi / 2.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureOptions:
    """The scene, and the camera that looks straight down at it.

    Attributes
    ----------
    scene_file
        Scene (YAML), for example of `config/scenes`.
    seed
        Seed of everything random in the scene; None: its own.
    middle_m
        Place of the middle of the area in the scene, east and north, metres.
    height_m
        Height of the camera above the ground, metres.
    width_px, height_px
        Size of a picture, pixels.
    fov_deg
        Field of view across the width, degrees.
    """

    scene_file: Path
    seed: int | None = None
    middle_m: tuple[float, float] = (0.0, 0.0)
    height_m: float = 32.0
    width_px: int = 64
    height_px: int = 64
    fov_deg: float = 60.0

    def __post_init__(self) -> None:
        require_between('height_m', self.height_m, 2.0, 1000.0, 'm')
        require_between('fov_deg', self.fov_deg, 5.0, 150.0, 'deg')
        require_count('width_px', self.width_px, 8, 4096)
        require_count('height_px', self.height_px, 8, 4096)


class EnginePictures(gymnasium.ObservationWrapper[Any, Any, Any]):
    """Adds `picture` (height, width, 3), red, green, blue, to what one drone observes.

    Parameters
    ----------
    env
        `SourceSearchEnv` or `SurveyEnv`.
    options
        Scene and camera.

    Raises
    ------
    SceneError, EngineError
        If the scene cannot be built or drawn; one line.

    Examples
    --------
    >>> options = PictureOptions(scene_file=Path('config/scenes/derailment.yaml'))
    >>> env = EnginePictures(SourceSearchEnv(), options)
    >>> observation, info = env.reset(seed=1)
    >>> observation['picture'].shape
    (64, 64, 3)
    """

    def __init__(self, env: gymnasium.Env[Any, Any], options: PictureOptions) -> None:
        super().__init__(env)
        self._eye = _Eye(options, env.get_wrapper_attr('area_m'))
        self.observation_space = with_picture(env.observation_space, options)

    def observation(self, observation: Observation) -> Observation:
        """Return an observation with its picture."""
        return self._eye.added_to(observation)


class FleetPictures(BaseParallelWrapper[str, Any, Any]):
    """Adds `picture` to what each drone of `FleetSearchEnv` observes, see `EnginePictures`."""

    def __init__(self, env: Any, options: PictureOptions) -> None:
        super().__init__(env)
        self._eye = _Eye(options, env.area_m)
        # The same objects at every call, as PettingZoo asks.
        self._spaces = {
            agent: with_picture(env.observation_space(agent), options)
            for agent in env.possible_agents
        }

    def observation_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return the space of what a drone observes."""
        return self._spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin."""
        found, infos = super().reset(seed, options)
        return self._with_pictures(found), infos

    def step(self, actions: dict[str, Any]) -> Any:
        """Fly and read."""
        found, *rest = super().step(actions)
        return (self._with_pictures(found), *rest)

    def _with_pictures(self, found: dict[str, Any]) -> dict[str, Any]:
        return {agent: self._eye.added_to(observed) for agent, observed in found.items()}


def with_picture(space: gymnasium.Space[Any], options: PictureOptions) -> spaces.Dict:
    """Return a space of observations with a picture in it."""
    if not isinstance(space, spaces.Dict) or 'pose' not in space.spaces:
        raise ValueError(f'observation_space is {space}: must be a Dict with `pose`')
    shape = (options.height_px, options.width_px, 3)
    return spaces.Dict({**space.spaces, 'picture': spaces.Box(0, 255, shape, np.uint8)})


@lru_cache(maxsize=1)
def scene_of(file: Path, seed: int | None) -> tuple[AnyRenderer, Terrain]:
    """Return what draws a scene, and its ground; environments of one process share them."""
    description = read_scene(file)
    environment = build(description, seed, cache=default_folder())
    return open_renderer(environment, description), environment.terrain


class _Eye:
    """Takes the picture of a drone by its pose, -1 to 1 over the area."""

    def __init__(self, options: PictureOptions, area_m: float) -> None:
        renderer, self._terrain = scene_of(options.scene_file, options.seed)
        self._half_m, self._options = 0.5 * area_m, options
        lens = PinholeCamera(math.radians(options.fov_deg), options.width_px, options.height_px)
        self._camera = renderer.camera(lens)

    def added_to(self, observation: Observation) -> Observation:
        picture = self._taken(observation['pose'])
        return {**observation, 'picture': picture}

    def _taken(self, pose: NDArray[np.float32]) -> NDArray[Any]:
        place = self._options.middle_m + self._half_m * pose.astype(float)
        up_m = float(self._terrain.height_at(place[None])[0]) + self._options.height_m
        frame = self._camera.expose(np.array([*place, up_m]), _DOWN)
        return np.ascontiguousarray(frame.image[..., ::-1])
