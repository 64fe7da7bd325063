# SPDX-License-Identifier: Apache-2.0
"""The ground of a scene is told at latitudes and longitudes, above the ellipsoid."""

import numpy as np
import pytest
from test.scene.scenes import FRAME

from rocsafe_geo.position import offset
from rocsafe_scene.ground.terrain import GridFrame, HeightGrid, Terrain
from rocsafe_scene.solids.ground_heights import SceneHeights, scene_heights


def hillside():
    """Return ground that rises a tenth to the east."""
    frame = GridFrame(west_m=-1000.0, south_m=-1000.0, cell_m=100.0, columns=21, rows=21)
    grid = HeightGrid(frame, np.tile(np.linspace(-100.0, 100.0, 21), (21, 1)))
    return Terrain(grid, grid, grid)


def test_altitudes_are_those_of_the_scene_about_its_origin():
    """At places 100 m to the east and west."""
    heights = SceneHeights(hillside(), FRAME)
    places = [offset(FRAME.origin, east, 30.0) for east in (-100.0, 0.0, 100.0)]
    found = heights.altitudes_m(
        [p.latitude_deg for p in places], [p.longitude_deg for p in places]
    )
    assert found - FRAME.origin.altitude_m == pytest.approx([-10.0, 0.0, 10.0], abs=0.02)


def test_a_scene_is_made_about_the_first_place(monkeypatch, tmp_path):
    """With the mission's seed; without a place it is refused."""
    asked = []

    def terrain_of(description, seed, origin):
        asked.append((description, seed, origin))
        return hillside()

    monkeypatch.setattr('rocsafe_scene.solids.ground_heights.terrain_of', terrain_of)
    monkeypatch.setattr('rocsafe_scene.solids.ground_heights.read_scene', lambda path: path.name)
    heights = scene_heights(str(tmp_path / 'hill.yaml'), 7, (FRAME.origin,))
    assert asked == [('hill.yaml', 7, FRAME.origin)]
    origin = FRAME.origin
    assert heights.altitudes_m([origin.latitude_deg], [origin.longitude_deg])[0] == pytest.approx(
        origin.altitude_m, abs=0.01
    )
    with pytest.raises(ValueError, match='the origin of the mission'):
        scene_heights('hill.yaml', 7, ())
