# SPDX-License-Identifier: Apache-2.0
"""Options describe a field or are refused in one line."""

import pytest

from rocsafe_radiation.field_parameters.field_options import FieldOptions

ONE_SOURCE = {
    'source_names': ('wreck',),
    'source_latitudes_deg': (53.28,),
    'source_longitudes_deg': (-9.06,),
    'source_altitudes_m': (60.0,),
    'source_sigmas_usvps': (2.57,),
}


def test_parallel_lists_make_sources():
    """One source a column."""
    field = FieldOptions(**ONE_SOURCE, source_radius_m=0.5).survey_field().field
    (source,) = field.sources
    assert (source.name, source.sigma_usvps) == ('wreck', 2.57)
    assert source.position.altitude_m == 60.0
    assert field.source_radius_m == 0.5


def test_defaults_are_valid():
    """A node without parameters starts."""
    assert FieldOptions().survey_field().field.sources == ()


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'model': 'lossy'}, "model = 'lossy' must be one of: paper"),
        (
            {'position_source': 'truth'},
            "position_source = 'truth' must be one of: ground_truth, fix",
        ),
        ({'source_sigmas_usvps': ()}, 'source_sigmas_usvps has 0 values, but source_names has 1'),
        ({'source_latitudes_deg': (1.0, 2.0)}, 'source_latitudes_deg has 2 values'),
        ({'source_latitudes_deg': (91.0,)}, 'source wreck: latitude_deg'),
        ({'source_sigmas_usvps': (-1.0,)}, 'source wreck: sigma_usvps = -1.0'),
        ({'source_radius_m': 0.0}, 'source_radius_m = 0.0'),
        ({'vehicles': ('rav1', 'rav1')}, 'vehicles'),
        ({'vehicles': ('',)}, 'vehicles'),
    ],
)
def test_a_wrong_option_is_named_with_its_value(change, message):
    """And with its limit."""
    with pytest.raises(ValueError, match=message):
        FieldOptions(**{**ONE_SOURCE, **change})
