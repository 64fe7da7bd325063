# SPDX-License-Identifier: Apache-2.0
"""Rays through a scene, with answers worked by hand."""

import numpy as np
import pytest
from test.scene.scenes import describe, plain_map

from rocsafe_scene.ground.terrain import INNER_HALF_M, OUTER_HALF_M, flat_terrain
from rocsafe_scene.mesh.shapes import box
from rocsafe_scene.scene.environment import Environment, Piece, SceneObject
from rocsafe_scene.solids.rays import RayScene


def boxes(*placed) -> Environment:
    """Return boxes (name, number, size, offset, material, fill) on flat ground."""
    objects = tuple(
        SceneObject(
            name=name,
            label='other',
            number=number,
            pieces=(Piece(mesh=box(*size, 0.001), rotation=np.eye(3), offset=np.array(offset)),),
            material=material,
            fill=fill,
        )
        for name, number, size, offset, material, fill in placed
    )
    return Environment(
        description=describe(), seed=1, terrain=flat_terrain(), inner=plain_map(INNER_HALF_M),
        outer=plain_map(OUTER_HALF_M), objects=objects,
    )  # fmt: skip


@pytest.fixture(scope='module')
def scene():
    """Return a wall of lead and a half-filled steel tank, 2 m and 4 m thick along east."""
    return RayScene(
        boxes(
            ('wall', 2, (2.0, 10.0, 5.0), (10.0, 0.0, 0.0), 'lead', 1.0),
            ('tank', 3, (4.0, 10.0, 5.0), (20.0, 0.0, 0.0), 'steel', 0.5),
        )
    )


def test_first_hits(scene):
    """The near wall, the ground below, and nothing above."""
    origins = np.array([[0.0, 0.0, 2.0]] * 3)
    directions = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]])
    hits = scene.first_hits(origins, directions)
    assert hits.numbers.tolist() == [2, 1, 0]
    assert hits.distances_m[:2] == pytest.approx([9.0, 2.0], abs=1e-5)
    assert np.isinf(hits.distances_m[2])


def test_lengths_by_material(scene):
    """Whole thickness for what is solid, its share for what is not; nothing beyond the end."""
    ends = np.array([[30.0, 0.0, 2.0], [10.0, 0.0, 2.0], [30.0, 9.0, 9.0], [-5.0, 0.0, 2.0]])
    lengths = scene.lengths_m(np.array([0.0, 0.0, 2.0]), ends)
    slanted = 2.0 * np.sqrt(30.0**2 + 9.0**2 + 7.0**2) / 30.0
    assert lengths['lead'] == pytest.approx([2.0, 1.0, slanted, 0.0], abs=1e-5)
    assert lengths['steel'] == pytest.approx([2.0, 0.0, 0.0, 0.0], abs=1e-5)


def test_a_source_inside_counts_from_where_it_lies(scene):
    """From the middle of the wall half of it is in the way."""
    lengths = scene.lengths_m(np.array([10.0, 0.0, 2.0]), np.array([[0.0, 0.0, 2.0]]))
    assert lengths['lead'] == pytest.approx([1.0], abs=1e-5)


def test_line_of_sight(scene):
    """The wall hides what is behind it, and not what is above it."""
    start = np.array([0.0, 0.0, 2.0])
    assert not scene.is_clear(start, np.array([15.0, 0.0, 2.0]))
    assert scene.is_clear(start, np.array([5.0, 0.0, 2.0]))
    assert scene.is_clear(start, np.array([15.0, 0.0, 12.0]))


def test_collision(scene):
    """A ball touches what it comes nearer to than its radius."""
    assert scene.collision(np.array([7.0, 0.0, 3.0]), 1.9) == ''
    assert scene.collision(np.array([7.0, 0.0, 3.0]), 2.1) == 'wall'
    assert scene.collision(np.array([10.0, 0.0, 6.0]), 1.1) == 'wall'
    assert scene.collision(np.array([0.0, 0.0, 0.5]), 0.6) == 'ground'


def test_height_above_ground(scene):
    """On flat ground it is the height."""
    assert scene.height_above_ground(np.array([[3.0, 4.0, 7.0]])) == pytest.approx([7.0])
