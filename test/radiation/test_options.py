# SPDX-License-Identifier: Apache-2.0
"""Parameters and the settings file describe a field, or are refused in one line."""

import pytest
import yaml
from test.geo.boxes import box_thing
from test.geo.test_solids_file import slope

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.solids.scene_solids import SceneSolids
from rocsafe_geo.solids.solids_file import write_solids
from rocsafe_radiation.field_parameters.field_making import survey_field
from rocsafe_radiation.field_parameters.field_options import FieldOptions

SOURCE = GeoPosition(53.28, -9.06, 66.0)
WRECK = {'name': 'wreck', 'position': [53.28, -9.06], 'sigma_usvps': 2.57}
THIEF = {
    'name': 'thief',
    'sigma_usvps': 2.0,
    'track': [
        {'time_s': 0.0, 'position': [53.28, -9.06]},
        {'time_s': 60.0, 'position': [53.281, -9.06]},
    ],
}
PLATE = {
    'material': 'iron', 'position': [53.28, -9.06], 'length_m': 20.0, 'width_m': 10.0,
    'height_m': 0.02, 'base_height_m': 1.0,
}  # fmt: skip


@pytest.fixture
def field_of(tmp_path):
    """Return a maker of the field of a settings file, and of parameters by name."""

    def make(content, **parameters):
        file = tmp_path / 'field.yaml'
        file.write_text(yaml.safe_dump(content))
        return survey_field(FieldOptions(field_file=str(file), **parameters))

    return make


def test_a_file_describes_a_source(field_of):
    """At its height above the ground."""
    content = {'sources': [{**WRECK, 'height_m': 1.5}], 'ground_altitude_m': 60.0}
    field = field_of(content, source_radius_m=0.5).field
    (source,) = field.sources
    assert (source.name, source.sigma_usvps, source.nuclide) == ('wreck', 2.57, 'Cs-137')
    assert source.position == GeoPosition(53.28, -9.06, 61.5)
    assert field.source_radius_m == 0.5


def test_a_node_without_parameters_has_no_source():
    """And no background."""
    field = survey_field(FieldOptions())
    assert field.field.sources == ()
    assert field.background.terrestrial_usvh == 0.0


def test_a_moving_source_leaves_its_shield(field_of):
    """The plate of iron over both takes its share from the one that stays, not from the other."""
    sources = [{**WRECK, 'sigma_usvps': 1.0}, THIEF]
    field = field_of({'sources': sources, 'shields': [PLATE]}, model='shielded').field
    bare = field_of({'sources': sources}, model='shielded').field
    place = (53.28, -9.06, 30.0)
    begun, over = (f.source_dose_rates_usvh(*place, 0.0)[:, 0] for f in (field, bare))
    assert begun == pytest.approx(0.58 * over, rel=0.1)
    left, free = (f.source_dose_rates_usvh(*place, 60.0)[:, 0] for f in (field, bare))
    assert left[0] == begun[0]
    assert left[1] == pytest.approx(free[1], rel=1e-6)


def rate_usvh(field):
    """Return the dose rate 32 m above the source."""
    above = offset(SOURCE, 0.0, 0.0, 32.0)
    place = (above.latitude_deg, above.longitude_deg, above.altitude_m)
    return float(field.dose_rates_usvh(*place)[0])


def test_things_of_a_scene_shield_beside_boxes(field_of, tmp_path):
    """A roof of 5 cm of lead lets less than a hundredth through, two of them far less.

    The path counts from the settings file; the models that know no shields ignore it.
    """
    roof = box_thing('roof', (4.0, 4.0, 0.05), (0.0, 0.0, 4.0), 'lead')
    solids = SceneSolids(origin=SOURCE, things=(roof,), ground=(slope(),))
    write_solids(tmp_path / 'yard.npz', solids)
    scene = {'sources': [{**WRECK, 'sigma_usvps': 1.0}], 'ground_altitude_m': 66.0}
    box = {
        'material': 'lead', 'position': [53.28, -9.06], 'length_m': 4.0, 'width_m': 4.0,
        'height_m': 0.05, 'base_height_m': 8.0,
    }  # fmt: skip
    shaded = {**scene, 'solids_file': 'yard.npz'}
    open_air = rate_usvh(field_of(scene, model='shielded'))
    one = rate_usvh(field_of(shaded, model='shielded'))
    assert one < 0.01 * open_air
    assert rate_usvh(field_of({**scene, 'shields': [box]}, model='shielded')) == pytest.approx(
        one, rel=1e-3
    )
    assert rate_usvh(field_of({**shaded, 'shields': [box]}, model='shielded')) < 0.02 * one
    assert rate_usvh(field_of(shaded, model='air')) == open_air


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'model': 'lossy'}, "model = 'lossy' must be one of: paper"),
        ({'detector': 'nose'}, "detector = 'nose' must be one of: ideal"),
        ({'vehicles': ('rav1', 'rav1')}, 'vehicles'),
        ({'vehicles': ('',)}, 'vehicles'),
    ],
)
def test_a_wrong_option_is_named_with_its_value(change, message):
    """And with its limit."""
    with pytest.raises(ValueError, match=message):
        FieldOptions(**change)


@pytest.mark.parametrize(
    ('content', 'message'),
    [
        ({'source': []}, r'source: unknown key \(did you mean sources\?\)'),
        ({'sources': [{'name': 'a'}]}, r'sources\[0\]: source a: needs exactly one of position'),
        ({'sources': [{**WRECK, 'line': [[53.0, -9.0]]}]}, 'needs exactly one of position'),
        ({'sources': [{**WRECK, 'activity_gbq': 1.0}]}, 'one of sigma_usvps, activity_gbq'),
        ({'sources': [{**WRECK, 'position': [91.0, 0.0]}]}, r'sources\[0\]: .*latitude_deg'),
        ({'sources': [{**WRECK, 'position': [53.0]}]}, 'position: must have 2 entries, has 1'),
        ({'sources': [{**WRECK, 'sigma_usvps': -1.0}]}, 'source wreck: sigma_usvps = -1.0'),
        ({'sources': [{**WRECK, 'nuclide': 'Xx-1'}]}, "source wreck: .*'Xx-1'"),
        ({'sources': [WRECK, WRECK]}, 'wreck'),
        ({'shields': [{**PLATE, 'material': 'butter'}]}, "material = 'butter': must be one of"),
        ({'shields': [{**PLATE, 'wall_m': 5.0}]}, r'shields\[0\]: wall_m = 5.0'),
        ({'shields': [{**PLATE, 'height_m': 0.0}]}, r'shields\[0\]: size_m'),
        ({'background': {'dose_rate_usvh': -1.0}}, 'terrestrial_usvh = -1.0 must be within'),
        ({'terrain_file': 'none.tif'}, 'none.tif: no such file'),
        ({'solids_file': 'none.npz'}, 'none.npz: no such file'),
        ({'ground_altitude_m': 1e5}, 'ground_altitude_m = 100000.0 must be within'),
    ],
)
def test_a_wrong_settings_file_is_refused(field_of, content, message):
    """In one line with its name, the place, the value and the limit."""
    with pytest.raises(ValueError, match=f'field.yaml: .*{message}') as caught:
        field_of(content, model='shielded')
    assert '\n' not in str(caught.value)
