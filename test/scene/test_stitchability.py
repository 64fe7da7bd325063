# SPDX-License-Identifier: Apache-2.0
"""Neighbouring photographs can be matched: what is seen is seen only once in the world."""

import math

import cv2
import numpy as np
import pytest
from test.scene.scenes import plain_map, small_environment

from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_scene.ground.ground_map import painted_map
from rocsafe_scene.ground.terrain import OUTER_HALF_M
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.scene.environment import Environment
from rocsafe_scene.scene.sunlight import lighting, sun_direction

pytest.importorskip('panda3d', reason='panda3d is not installed')
from rocsafe_scene.engine.oversampled_camera import OversampledCamera
from rocsafe_scene.engine.renderer import Renderer

pytestmark = pytest.mark.slow

LENS = PinholeCamera(math.radians(60.0), 640, 480)
HEIGHT_M, OVERLAP = 32.0, 0.4
TREES_M = 9.0
# Of an open and of a closed wood: trees on 2500 m2, and the least share of a picture they fill.
OPEN, CLOSED = (40, 0.3), (60, 0.6)


def wood(count: int) -> dict:
    """Return a wood of so many trees on 2500 m2."""
    outline = ((-20.0, -22.0), (20.0, -22.0), (20.0, 40.0), (-20.0, 40.0))
    return {
        'name': 'wood',
        'make': 'tree',
        'with': {'height': TREES_M, 'radius': 3.6},
        'scatter': {'count': count, 'outline': outline},
    }


FAR = {'name': 'mark', 'make': 'drum', 'at': (140.0, 120.0)}


def scene(thing: dict, seed: int) -> Environment:
    """Return a meadow of true detail with `thing` on it."""
    plain = small_environment(thing, seed=seed)
    return Environment(
        description=plain.description,
        seed=plain.seed,
        terrain=plain.terrain,
        inner=painted_map((), seed, 2, (40.96, 40.96)),
        outer=plain_map(OUTER_HALF_M),
        objects=plain.objects,
    )


def shots(environment: Environment, level_m: float = 0.0) -> list:
    """Return two photographs side by side as vehicles take them, with their positions.

    What lies `level_m` high overlaps as is asked.
    """
    time = environment.description.light.time
    light = lighting(sun_direction(time, 53.28, -9.06), 'clear')
    studio = OversampledCamera(Renderer(environment, light), LENS)
    step = (1.0 - OVERLAP) * LENS.footprint_m(HEIGHT_M - level_m)[1]
    found = []
    for north in (0.0, step):
        position = np.array([0.0, north, HEIGHT_M])
        found.append((studio.expose(position, rotation_enu_from_optical(math.pi / 2)), position))
    return found


def matched(first, second) -> tuple[int, float]:
    """Return how many points match, and the share that the depth says is right within 2 px.

    A key point covers a patch: the depth of any of its nine middle pixels may be the one meant.
    """
    (frame, position), (other, other_position) = first, second
    orb = cv2.ORB_create(4000)
    points, described = orb.detectAndCompute(frame.image, None)
    other_points, other_described = orb.detectAndCompute(other.image, None)
    pairs = cv2.BFMatcher(cv2.NORM_HAMMING).knnMatch(described, other_described, k=2)
    good = [a for a, b in pairs if a.distance < 0.8 * b.distance]
    rotation = rotation_enu_from_optical(math.pi / 2)
    start = np.array([points[match.queryIdx].pt for match in good])
    end = np.array([other_points[match.trainIdx].pt for match in good])
    rays = np.column_stack([start, np.ones(len(start))]) @ np.linalg.inv(LENS.matrix).T
    column, row = np.rint(start).astype(int).T
    errors = []
    for shift_row, shift_column in np.ndindex(3, 3):
        at = (np.clip(row + shift_row - 1, 0, 479), np.clip(column + shift_column - 1, 0, 639))
        world = (rays * frame.depth_m[at][:, None]) @ rotation.T + position
        seen = (world - other_position) @ rotation @ LENS.matrix.T
        errors.append(np.linalg.norm(seen[:, :2] / seen[:, 2:] - end, axis=1))
    error = np.min(errors, axis=0)
    return len(good), float(np.mean(error < 2.0))


@pytest.mark.parametrize('seed', [6, 13])
def test_photographs_match_at_40_percent_overlap(drawing, seed):
    """On open ground at least 250 ORB matches, and at least 80 % of them right."""
    found, right = matched(*shots(scene(FAR, seed)))
    assert found >= 250
    assert right >= 0.8


@pytest.mark.parametrize('seed', [1, pytest.param(2, marks=pytest.mark.all)])
@pytest.mark.parametrize('density', [OPEN, CLOSED], ids=['open', 'closed'])
def test_photographs_of_a_wood_match_at_40_percent_overlap_of_its_crowns(drawing, density, seed):
    """Where the tops of the trees overlap by 40 %: at least 100 ORB matches, 60 % right."""
    count, cover = density
    require_matches(shots(scene(wood(count), seed), TREES_M), cover)


@pytest.mark.parametrize('seed', [1, pytest.param(3, marks=pytest.mark.all)])
def test_photographs_of_an_open_wood_match_at_40_percent_overlap_of_its_ground(drawing, seed):
    """Their tops overlap by half as much, so that not every such wood does."""
    count, cover = OPEN
    require_matches(shots(scene(wood(count), seed)), cover)


def require_matches(photographs: list, cover: float) -> None:
    """Require matches of a wood whose crowns fill at least `cover` of a picture."""
    first, second = photographs
    assert (first[0].classes == class_number('tree')).mean() > cover
    found, right = matched(first, second)
    assert found >= 100
    assert right >= 0.6
