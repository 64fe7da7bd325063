# SPDX-License-Identifier: Apache-2.0
"""Cameras and surroundings that all vehicles of a process share."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import cv2

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.cameras.camera import Camera
from rocsafe_scene.cameras.ground_camera import GroundCamera
from rocsafe_scene.errors import EngineError
from rocsafe_scene.flat_ground.ground_photograph import read_photograph
from rocsafe_scene.flat_ground.scene_ground import SceneGround
from rocsafe_scene.ground.ground_patch import Ground
from rocsafe_scene.ground.orthophoto import OrthophotoGround
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_sim.cameras.camera_settings import CameraSettings
from rocsafe_sim.cameras.mounted_camera import CameraModel, optics_of
from rocsafe_sim.flight.sensing_options import ENGINE, SCENE_GROUND, SensingOptions
from rocsafe_sim.options import VehicleOptions
from rocsafe_sim.vehicle.surroundings import Surroundings


@dataclass(frozen=True, slots=True, kw_only=True)
class SharedParts:
    """Parts that all vehicles of a process share.

    Attributes
    ----------
    cameras
        Cameras of each vehicle.
    surroundings
        Ground and obstacles; None: there are no obstacles.
    """

    cameras: tuple[CameraModel, ...]
    surroundings: Surroundings | None


def make_shared(options: VehicleOptions) -> SharedParts:
    """Return the cameras and the surroundings of the vehicles.

    Raises
    ------
    ValueError
        If the file of the cameras is wrong.
    ViewError
        If the ground, the scene or the engine cannot be loaded.
    """
    return shared_parts(options, options.cameras())


def shared_parts(options: SensingOptions, cameras: Iterable[CameraSettings]) -> SharedParts:
    """Return these cameras in the scene of the options, and their surroundings.

    Raises
    ------
    ViewError
        If the ground, the scene or the engine cannot be loaded.
    """
    # Each vehicle is a process: threads of OpenCV would compete for the same cores.
    cv2.setNumThreads(1)
    is_engine = options.camera_backend == ENGINE
    draws, surroundings = _engine(options) if is_engine else _flat(options)
    models = tuple(
        CameraModel(settings=settings, camera=draws(settings), optics=optics_of(settings))
        for settings in cameras
    )
    return SharedParts(cameras=models, surroundings=surroundings)


def _flat(options: SensingOptions) -> tuple[Callable[[CameraSettings], Camera], None]:
    """Return a maker of cameras over the flat ground, which has no obstacles."""
    ground = make_ground(options)
    return lambda settings: GroundCamera(settings.drawn_lens, ground), None


def _engine(
    options: SensingOptions,
) -> tuple[Callable[[CameraSettings], Camera], Surroundings]:
    """Return a maker of cameras in the scene, and the scene as surroundings."""
    # Imported on use: the engine need not be installed for the flat ground.
    try:
        from rocsafe_scene.cameras.engine_camera import EngineCamera, EngineRequest, EngineScene
    except ModuleNotFoundError as error:
        raise EngineError(
            f'camera_backend engine: Python module {error.name} is missing: run `make setup`'
        ) from error
    from rocsafe_scene.solids.scene_surroundings import SceneSurroundings

    scene = EngineScene(
        EngineRequest(
            scene_file=Path(options.scene_file),
            seed=options.seed,
            origin=options.frame().origin,
            start_ns=round(options.scene_start_s * NS_PER_S),
            cache=default_folder(),
        )
    )

    def draws(settings: CameraSettings) -> Camera:
        return EngineCamera(scene, settings.drawn_lens, settings.oversampling)

    return draws, SceneSurroundings(scene.environment)


def make_ground(options: SensingOptions) -> Ground:
    """Return the image of the flat ground.

    Raises
    ------
    GroundError
        If its file cannot be read.
    """
    if options.ground == SCENE_GROUND:
        return SceneGround(read_photograph(options.scene), options.seed)
    return OrthophotoGround(Path(options.ground), options.frame())
