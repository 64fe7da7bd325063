# SPDX-License-Identifier: Apache-2.0
"""Things of a scene shield from the radiation core's point of view: by material, in degrees."""

import dataclasses

import numpy as np
import pytest
from test.scene.test_rays import boxes

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.errors import SceneError
from rocsafe_scene.solids.shielding import SceneShielding, scene_shielding

ORIGIN = GeoPosition(53.28, -9.06, 66.0)
FRAME = LocalFrame(ORIGIN)


def coordinates(*places):
    """Return places in metres as latitudes, longitudes and altitudes."""
    latitudes, longitudes, altitudes = FRAME.to_geodetic(np.array(places)).T
    return latitudes, longitudes, altitudes


@pytest.fixture(scope='module')
def things():
    """Return a wall of lead, a half-filled tank of steel, a wall of brick and a tree."""
    return boxes(
        ('wall', 2, (2.0, 10.0, 5.0), (10.0, 0.0, 0.0), 'lead', 1.0),
        ('tank', 3, (4.0, 10.0, 5.0), (20.0, 0.0, 0.0), 'steel', 0.5),
        ('house', 4, (1.0, 10.0, 5.0), (0.0, 50.0, 0.0), 'brick', 1.0),
        ('tree', 5, (4.0, 4.0, 9.0), (-20.0, 0.0, 0.0), 'wood', 0.01),
    ).objects


def test_rays_pass_materials_of_photons(things):
    """From two sources: through lead and half of the tank, and through brick, light concrete."""
    shielding = SceneShielding(FRAME, things)
    lengths = shielding.lengths_m(
        coordinates((0.0, 0.0, 2.0), (0.0, 40.0, 2.0)),
        coordinates((30.0, 0.0, 2.0), (0.0, 60.0, 2.0)),
    )
    assert lengths['lead'][0] == pytest.approx([2.0, 0.0], abs=1e-4)
    assert lengths['iron'][0] == pytest.approx([2.0, 0.0], abs=1e-4)
    assert lengths['concrete'][:, 1] == pytest.approx([7.8, 7.8], abs=1e-3)
    assert set(lengths) == {'lead', 'iron', 'concrete'}


def test_leaves_do_not_shield(things):
    """Nor does what is of a material that nobody knows."""
    strange = [dataclasses.replace(thing, is_foliage=True) for thing in things[3:]]
    strange += [dataclasses.replace(thing, material='glass') for thing in things[:3]]
    rays = coordinates((-30.0, 0.0, 2.0)), coordinates((30.0, 0.0, 2.0))
    assert SceneShielding(FRAME, strange).lengths_m(*rays) == {}


def test_a_scene_that_is_not_there_is_told_in_one_line(tmp_path):
    """As by all who read scenes."""
    with pytest.raises(SceneError, match='gone'):
        scene_shielding(str(tmp_path / 'gone.yaml'), 1, ORIGIN)
