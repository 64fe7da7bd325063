# SPDX-License-Identifier: Apache-2.0
"""Things of a scene stand for materials that photons know."""

import numpy as np
import pytest
from test.geo.boxes import box_thing
from test.geo.test_solids_file import slope

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.scene_solids import SceneSolids
from rocsafe_radiation.physics.photons import materials
from rocsafe_radiation.physics.scene_shielding import PHOTON_MATERIALS, SceneShielding

ORIGIN = GeoPosition(53.28, -9.06, 66.0)
FRAME = LocalFrame(ORIGIN)


def coordinates(*places):
    """Return places in metres as latitudes, longitudes and altitudes."""
    latitudes, longitudes, altitudes = FRAME.to_geodetic(np.array(places)).T
    return latitudes, longitudes, altitudes


def shielding(*things):
    """Return how `things` shield."""
    return SceneShielding(SceneSolids(origin=ORIGIN, things=things, ground=(slope(),)))


def test_rays_pass_materials_of_photons():
    """From two sources: through lead and half of the tank, and through brick, light concrete."""
    lengths = shielding(
        box_thing('wall', (2.0, 10.0, 5.0), (10.0, 0.0, 0.0), 'lead'),
        box_thing('tank', (4.0, 10.0, 5.0), (20.0, 0.0, 0.0), 'steel', 0.5),
        box_thing('house', (1.0, 10.0, 5.0), (0.0, 50.0, 0.0), 'brick'),
    ).lengths_m(
        coordinates((0.0, 0.0, 2.0), (0.0, 40.0, 2.0)),
        coordinates((30.0, 0.0, 2.0), (0.0, 60.0, 2.0)),
    )
    assert lengths['lead'][0] == pytest.approx([2.0, 0.0], abs=1e-4)
    assert lengths['iron'][0] == pytest.approx([2.0, 0.0], abs=1e-4)
    assert lengths['concrete'][:, 1] == pytest.approx([7.8, 7.8], abs=1e-3)
    assert set(lengths) == {'lead', 'iron', 'concrete'}


def test_what_is_of_an_unknown_material_does_not_shield():
    """Glass is not in the table; an empty scene shields nothing either."""
    rays = coordinates((-30.0, 0.0, 2.0)), coordinates((30.0, 0.0, 2.0))
    pane = box_thing('pane', (2.0, 10.0, 5.0), (10.0, 0.0, 0.0), 'glass')
    assert shielding(pane).lengths_m(*rays) == {}
    assert shielding().lengths_m(*rays) == {}


def test_each_material_of_a_scene_stands_for_one_that_photons_know():
    """With at most its own length."""
    for name, share in PHOTON_MATERIALS.values():
        assert name in materials()
        assert 0.0 < share <= 1.0
