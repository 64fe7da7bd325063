# SPDX-License-Identifier: Apache-2.0
"""Small scenes for tests: a few things on rolling ground, quick to make."""

import numpy as np

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.ground.relief import Relief
from rocsafe_scene.ground.terrain import INNER_HALF_M, OUTER_HALF_M, make_terrain
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.scene.description import SceneDescription
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.scene.placing import Placer

FRAME = LocalFrame(GeoPosition(53.28, -9.06, 60.0))
THINGS = (
    {'name': 'tank', 'make': 'tank_car', 'at': (2.0, 1.0), 'yaw_deg': 30.0},
    {'name': 'van', 'make': 'ambulance', 'at': (-9.0, 5.0), 'yaw_deg': 200.0},
    {'name': 'home', 'make': 'house', 'at': (10.0, -9.0)},
    {'name': 'flask', 'make': 'flask', 'at': (-4.0, -6.0), 'roll_deg': 40.0, 'height_m': 0.6},
)
PLANT = {'name': 'oak', 'make': 'tree', 'at': (-10.0, -4.0)}


def describe(*objects: dict, **other: object) -> SceneDescription:
    """Return a description of `objects`."""
    return SceneDescription.model_validate({'name': 'test', 'objects': objects, **other})


def plain_map(half_m: tuple[float, float], seed: int = 3) -> GroundMap:
    """Return noise of 0.5 m texels for ground."""
    columns, rows = (round(4.0 * half) for half in half_m)
    rng = np.random.default_rng(seed)
    colours = rng.integers(60, 160, (rows, columns, 3)).astype(np.uint8)
    classes = np.full((rows // 4, columns // 4), class_number('grass'), np.uint8)
    return GroundMap(-half_m[0], -half_m[1], 0.5, colours, classes)


def small_environment(*objects: dict, relief_m: float = 1.5, seed: int = 4) -> Environment:
    """Return a scene of `objects`, by default a handful, on rolling ground."""
    description = describe(*(objects or THINGS))
    terrain = make_terrain(Relief(seed=4, local_m=relief_m, hills_m=20.0).heights)
    return Environment(
        description=description,
        seed=4,
        terrain=terrain,
        inner=plain_map(INNER_HALF_M),
        outer=plain_map(OUTER_HALF_M),
        objects=tuple(Placer(description, seed, FRAME, terrain).objects()),
    )
