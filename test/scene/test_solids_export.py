# SPDX-License-Identifier: Apache-2.0
"""A scene's closed things and ground reach a file that others read."""

import numpy as np
import pytest
from test.scene.scenes import FRAME, describe

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.solids_file import read_solids
from rocsafe_scene.command_line.scene_command import main
from rocsafe_scene.scene.building import check, terrain_of
from rocsafe_scene.solids.solids_export import solids_of

SCENE = """\
name: yard
place: {latitude_deg: 53.28, longitude_deg: -9.06, altitude_m: 66.0}
objects:
  - {name: van, make: ambulance, at: [0.0, 0.0]}
  - {name: oak, make: tree, at: [20.0, 5.0]}
"""


def test_leaves_are_left_out_and_all_else_is_where_it_stands():
    """Bounds, material and fill are those of the built scene."""
    objects = (
        {'name': 'van', 'make': 'ambulance', 'at': (3.0, 4.0)},
        {'name': 'oak', 'make': 'tree', 'at': (20.0, 5.0)},
        {'name': 'tent', 'make': 'tent', 'at': (-20.0, 5.0)},
    )
    described = describe(*objects)
    origin = FRAME.origin
    solids = solids_of(described, 3, origin)
    built = {thing.name: thing for thing in check(described, 3, origin)}
    assert [thing.name for thing in solids.things] == ['van', 'tent']
    for thing in solids.things:
        expected = built[thing.name]
        corners = thing.corners_enu_m.reshape(-1, 3)
        bounds = [corners.min(axis=0), corners.max(axis=0)]
        assert np.abs(bounds - expected.bounds).max() < 1e-4
        assert (thing.material, thing.fill) == (expected.material, expected.fill)
    places = np.random.default_rng(1).uniform(-600.0, 600.0, (200, 2))
    geodetic = FRAME.to_geodetic(np.column_stack([places, np.zeros(200)]))
    up = FRAME.to_enu(
        geodetic[:, 0], geodetic[:, 1], solids.altitudes_m(geodetic[:, 0], geodetic[:, 1])
    )[:, 2]
    assert up == pytest.approx(terrain_of(described, 3, origin).height_at(places), abs=0.01)


def test_the_command_writes_the_file(tmp_path, capsys):
    """About the origin given, with its things; what cannot be read is told in one line."""
    scene, file = tmp_path / 'yard.yaml', tmp_path / 'yard.npz'
    scene.write_text(SCENE)
    arguments = ['solids', str(scene), '--out', str(file), '--seed=5']
    assert main([*arguments, '--origin=53.281,-9.061,70.5']) == 0
    assert capsys.readouterr().out == f'{file}\n'
    found = read_solids(file)
    assert found.origin == GeoPosition(53.281, -9.061, 70.5)
    assert [thing.name for thing in found.things] == ['van']
    assert main(['solids', str(tmp_path / 'gone.yaml')]) == 2
    assert main([*arguments, '--origin=91,0,0']) == 2
    assert main(['solids', str(scene), '--out', str(tmp_path / 'no' / 'yard.npz')]) == 2
    assert all(line.startswith('rocsafe: ') for line in capsys.readouterr().err.splitlines())
