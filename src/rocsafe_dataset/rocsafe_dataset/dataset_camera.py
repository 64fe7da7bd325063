# SPDX-License-Identifier: Apache-2.0
"""Rendering and labelling of the images of a data set."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from rocsafe_dataset.errors import DatasetError
from rocsafe_dataset.folder.files import LARGEST_NUMBER, DatasetFolder, LabelledImage
from rocsafe_dataset.labels.annotations import annotate, large_enough
from rocsafe_dataset.options import DatasetOptions
from rocsafe_dataset.poses.arrangements import MOVABLE, Arrangement, arrange, bounds_of, box_of
from rocsafe_dataset.poses.ground_splits import divide_ground
from rocsafe_dataset.poses.image_poses import Site, draw_pose
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.engine.oversampled_camera import OversampledCamera, open_renderer
from rocsafe_scene.engine.renderer import Renderer
from rocsafe_scene.engine.silhouettes import Silhouettes
from rocsafe_scene.graphics.pipe import EGL_PACKAGES
from rocsafe_scene.ground.terrain import INNER_HALF_M
from rocsafe_scene.scene.building import build
from rocsafe_scene.scene.description import SceneDescription
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.scene.sunlight import lighting, sun_direction

# Classes at which images are not aimed: they are everywhere.
_PLANTS = frozenset(('tree', 'hedge', 'shrub', 'fence', 'cordon'))
_NS_PER_US = 1000


class DatasetCamera:
    """Renders images of one scene into one folder.

    Parameters
    ----------
    environment
        Scene to render.
    folder
        Folder of the data set.

    Raises
    ------
    DatasetError, EngineError
        One line.
    """

    def __init__(self, environment: Environment, folder: DatasetFolder) -> None:
        if environment.objects and environment.objects[-1].number > LARGEST_NUMBER:
            raise DatasetError(
                f'{len(environment.objects)} objects: masks hold {LARGEST_NUMBER} at most'
            )
        self._environment, self._folder = environment, folder
        options = folder.options
        renderer = open_renderer(environment, environment.description)
        if not isinstance(renderer, Renderer):
            raise DatasetError(f'data sets need EGL (apt: {EGL_PACKAGES}); here is only: '
                               f'{renderer.pipe.renderer}')  # fmt: skip
        self._renderer = renderer
        self._camera = OversampledCamera(self._renderer, options.lens, options.oversampling)
        self._silhouettes = Silhouettes(self._renderer, options.lens)
        self._site = site_of(environment, options)
        place = environment.description.place
        self._frame = LocalFrame(
            GeoPosition(place.latitude_deg, place.longitude_deg, place.altitude_m)
        )

    def photograph(self, arrangement: int, numbers: Sequence[int]) -> Iterator[int]:
        """Render images of an arrangement; yield the number of each when its files are written."""
        state = arrange(arrangement, self._environment, self._folder.options)
        place = self._environment.description.place
        sun = sun_direction(state.time, place.latitude_deg, place.longitude_deg)
        light = lighting(sun, state.weather)
        self._renderer.rearrange(state.objects, light)
        for number in numbers:
            self._folder.write(self._picture(number, state), self._frame)
            yield number

    def _picture(self, number: int, state: Arrangement) -> LabelledImage:
        planned = draw_pose(number, self._site, self._folder.options)
        frame = self._camera.expose(planned.position, planned.rotation)
        objects = {thing.number: thing for thing in state.objects}
        found = large_enough(frame, self._folder.options.least_pixels)
        # All instances of the image are needed: each can hide others.
        bounds = {k: bounds_of(objects[k]) for k in found}
        pose = planned.position, planned.rotation
        shares = self._silhouettes.visible_shares(frame.numbers, bounds, pose)
        ground = float(self._site.terrain.height_at(planned.position[None, :2])[0])
        return LabelledImage(
            pose=planned,
            frame=frame,
            annotations=annotate(frame, objects, shares),
            weather=state.weather,
            time_ns=int(state.time.timestamp() * 1e6) * _NS_PER_US,
            height_m=float(planned.position[2]) - ground,
            renderer=self._renderer.pipe.renderer,
        )


def open_dataset_camera(
    description: SceneDescription, folder: DatasetFolder, cache: Path
) -> DatasetCamera:
    """Return the camera of a data set in the scene of a scene file.

    Raises
    ------
    SceneError, EngineError, DatasetError
        One line.
    """
    return DatasetCamera(build(description, cache=cache), folder)


def site_of(environment: Environment, options: DatasetOptions) -> Site:
    """Return the site over which the poses of a data set are drawn."""
    worth = [
        piece.offset[:2]
        for thing in environment.objects
        if thing.label not in _PLANTS
        for piece in thing.pieces
    ]
    aims = np.array(worth).reshape(-1, 2)
    boxes = [
        box_of(piece)
        for thing in environment.objects
        if thing.label not in MOVABLE
        for piece in thing.pieces
    ]
    return Site(
        terrain=environment.terrain,
        places=divide_ground(INNER_HALF_M, aims, options.splits, options.seed),
        aims=aims,
        boxes=np.array(boxes).reshape(-1, 2, 3),
    )
