# SPDX-License-Identifier: Apache-2.0
"""Whoever is named answers for what stands in the way, beside the boxes."""

import numpy as np
import pytest

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_radiation.field_parameters.field_options import FieldOptions
from rocsafe_radiation.field_parameters.shielding_provider import provided_shielding

SOURCE = GeoPosition(53.28, -9.06, 66.0)
ABOVE = offset(SOURCE, 0.0, 0.0, 32.0)


class Slab:
    """Five centimetres of lead in each ray."""

    def lengths_m(self, starts, points):
        """Return them."""
        return {'lead': np.full((len(starts[0]), len(points[0])), 0.05)}


def slab(file, seed, origin):
    """Return the slab of a scene that must be called so."""
    if file != 'slab.yaml' or seed != 3 or origin.altitude_m != 66.0:
        raise OSError(f'{file}: no such scene')
    return Slab()


def rate_usvh(**changes):
    """Return the dose rate 32 m above the source."""
    options = FieldOptions(
        source_names=('capsule',),
        source_latitudes_deg=(SOURCE.latitude_deg,),
        source_longitudes_deg=(SOURCE.longitude_deg,),
        source_altitudes_m=(SOURCE.altitude_m,),
        source_sigmas_usvps=(1.0,),
        origin_latitude_deg=SOURCE.latitude_deg,
        origin_longitude_deg=SOURCE.longitude_deg,
        origin_altitude_m=66.0,
        seed=3,
        **changes,
    )
    place = (ABOVE.latitude_deg, ABOVE.longitude_deg, ABOVE.altitude_m)
    return float(options.survey_field().dose_rates_usvh(*place)[0])


SLAB = {'shielding': f'{__name__}:slab', 'shielding_file': 'slab.yaml'}


def test_things_of_a_scene_shield():
    """5 cm of lead let less than a hundredth of caesium through; the model air sees none."""
    open_air = rate_usvh(model='air')
    assert rate_usvh(model='shielded', **SLAB) < 0.01 * open_air
    assert rate_usvh(model='air', **SLAB) == open_air


def test_a_scene_adds_to_boxes():
    """A roof of lead above the source, thick as the slab: twice as many half-value layers."""
    box = {
        'box_materials': ('lead',),
        'box_latitudes_deg': (SOURCE.latitude_deg,),
        'box_longitudes_deg': (SOURCE.longitude_deg,),
        'box_altitudes_m': (70.0,),
        'box_lengths_m': (4.0,),
        'box_widths_m': (4.0,),
        'box_heights_m': (0.05,),
    }
    both = rate_usvh(model='shielded', **SLAB, **box)
    scene = rate_usvh(model='shielded', **SLAB)
    assert rate_usvh(model='shielded', **box) == pytest.approx(scene, rel=1e-3)
    assert both < 0.02 * scene


@pytest.mark.parametrize(
    ('name', 'file', 'words'),
    [
        ('no_such_module:slab', 'slab.yaml', 'shielding = .*no_such_module'),
        (f'{__name__}:none', 'slab.yaml', 'shielding = .*none'),
        (f'{__name__}:slab', 'gone.yaml', 'shielding_file = .gone.yaml.: gone.yaml: no such'),
    ],
)
def test_who_does_not_answer_is_named(name, file, words):
    """In one line."""
    with pytest.raises(ValueError, match=words):
        provided_shielding(name, file, 3, SOURCE)
