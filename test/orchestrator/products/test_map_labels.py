# SPDX-License-Identifier: Apache-2.0
"""Names of marks at one place of the map lie on different sides."""

import re

import pytest

from rocsafe_orchestrator.products.summary import HighestReading
from rocsafe_orchestrator.report.map_data import SourcePoint
from rocsafe_orchestrator.report.map_layers import highest_layer

TRUTH = SourcePoint(10.0, 10.0, 'capsule')


def label_y(place, sources):
    """Return how far below its mark the name of the highest reading stands, pixels."""
    highest = HighestReading.__new__(HighestReading)
    object.__setattr__(highest, 'dose_rate_usvh', 1.5)
    text = str(highest_layer(highest, place, sources))
    return float(re.search(r'label-middle" y="([-0-9.]+)"', text)[1])


@pytest.mark.parametrize(
    ('place', 'sources', 'is_below'),
    [
        ((12.0, 5.0), [TRUTH], False),
        ((12.0, 15.0), [TRUTH], True),
        ((12.0, 5.0), [], True),
    ],
)
def test_the_highest_reading_is_named_away_from_the_nearest_source(place, sources, is_below):
    """North of it above, else below: the names of sources stand beside these."""
    assert (label_y(place, sources) > 0.0) == is_below
