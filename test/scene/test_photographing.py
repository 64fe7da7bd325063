# SPDX-License-Identifier: Apache-2.0
"""Photographs from straight above: without perspective, at the right scale and place."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test.scene.scenes import small_environment

from rocsafe_scene.flat_ground.scene_box import boxes_of
from rocsafe_scene.scene.sunlight import lighting

pytest.importorskip('panda3d', reason='panda3d is not installed')
from ground_photographs import PhotographOptions, photograph_of
from rocsafe_scene.engine.renderer import Renderer
from rocsafe_scene.graphics.pipe import open_pipe

OPTIONS = PhotographOptions(tiles=(2, 1), texel_m=0.05, oversampling=2)
# On both sides of the seam between the tiles, and high above the ground.
TENTS = (
    {'name': 'low', 'make': 'tent', 'at': (8.0, 3.0), 'with': {'colour': [255, 0, 255]}},
    {
        'name': 'high', 'make': 'tent', 'at': (-9.0, -4.0), 'height_m': 20.0, 'yaw_deg': 30.0,
        'with': {'colour': [0, 255, 255]},
    },
)  # fmt: skip


def centre_of(chosen: np.ndarray) -> np.ndarray:
    """Return (east, north) of the middle of the chosen pixels."""
    rows, columns = np.nonzero(chosen)
    height, width = chosen.shape
    middle = np.array([columns.min() + columns.max(), rows.min() + rows.max()]) / 2.0
    return (middle - 0.5 * np.array([width - 1, height - 1])) * (0.05, -0.05)


@pytest.mark.slow
def test_things_are_where_their_boxes_are_however_high_they_stand(drawing):
    """The middle of a tent's colour is that of its box, within 15 cm for lit and shaded sides."""
    if open_pipe().is_degraded:
        pytest.skip('photographs need EGL')
    environment = small_environment(*TENTS, relief_m=0.0)
    grey = np.full_like(environment.inner.colours, 120)
    environment = replace(environment, inner=replace(environment.inner, colours=grey))
    light = lighting(np.array([0.0, 0.0, 1.0]), 'clear')
    image = photograph_of(Renderer(environment, light), OPTIONS).astype(int)
    assert image.shape == (512, 1024, 3)
    boxes = {box.name: box for box in boxes_of(environment.objects, (25.6, 12.8))}
    blue, green, red = np.moveaxis(image, -1, 0)
    seen = {
        'low': (red - green > 60) & (blue - green > 60),
        'high': (blue - red > 60) & (green - red > 60),
    }
    for name, chosen in seen.items():
        assert centre_of(chosen) == pytest.approx(boxes[name].position_enu[:2], abs=0.15)


@pytest.mark.slow
def test_boxes_are_the_smallest_around_their_pieces():
    """All corners of a piece lie in its box, and touch each of its six sides."""
    objects = small_environment().objects
    boxes = {box.name: box for box in boxes_of(objects, (100.0, 100.0))}
    for thing in objects:
        (piece,) = thing.pieces
        box = boxes[thing.name]
        turn = Rotation.from_quat(box.quaternion).as_matrix()
        inside = (piece.points() - box.position_enu) @ turn
        low, high = inside.min(axis=0), inside.max(axis=0)
        assert high == pytest.approx(0.5 * np.array(box.size_m), abs=0.005)
        assert low == pytest.approx(-0.5 * np.array(box.size_m), abs=0.005)


def test_small_and_distant_objects_have_no_boxes():
    """A drum half a metre wide is 0.9 m high; evidence markers are left out, as is what is far."""
    things = (
        {'name': 'drum', 'make': 'drum', 'at': (1.0, 1.0)},
        {'name': 'far_drum', 'make': 'drum', 'at': (40.0, 1.0)},
        {'name': 'marker', 'make': 'evidence_marker', 'at': (2.0, 2.0)},
    )
    boxes = boxes_of(small_environment(*things).objects, (30.0, 30.0))
    assert [box.name for box in boxes] == ['drum']
