# SPDX-License-Identifier: Apache-2.0
"""Plans in three lines of Python."""

import json

import pytest

from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.export.plan_geojson import area_rings
from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.region_plan import plan_region

from .fleets import RECTANGLE


@pytest.fixture
def region_file(tmp_path):
    """Write the seed's rectangle as GeoJSON."""
    path = tmp_path / 'yard.geojson'
    path.write_text(json.dumps({'type': 'Polygon', 'coordinates': area_rings(RECTANGLE)}))
    return path


@pytest.mark.slow
def test_a_region_file_and_a_number_of_drones(region_file):
    """All is seen, by as many drones, with a proof; what is not said has defaults."""
    plan = plan_region(region_file, drones=2, effort=Effort(proposals=20_000))
    assert [route.vehicle.name for route in plan.routes] == ['rav1', 'rav2']
    assert plan.covered_fraction == pytest.approx(1.0)
    assert plan.request.effort.method == 'solver'
    assert 0.0 <= plan.gap_fraction < 0.2
    assert check_plan(plan) == []


def test_options_are_those_of_a_request(region_file):
    """Any field of a request may be named; a wrong one is refused as there."""
    assert (
        plan_region(region_file, effort=Effort(method='strips')).request.effort.method == 'strips'
    )
    with pytest.raises(ValueError, match='drones is 0: must be 1 to 1000'):
        plan_region(region_file, drones=0)
    with pytest.raises(ValueError, match="method is 'x': must be one of"):
        plan_region(region_file, effort=Effort(method='x'))
