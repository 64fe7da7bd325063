# SPDX-License-Identifier: Apache-2.0
"""A plan file read back is the plan."""

import dataclasses
import json

import pytest

from rocsafe_geo.position import distance_m
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.plan.plan_json import plan_document
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_planner.planning import plan_survey

from .fleets import FLEET, request


def written(tmp_path, plan, **changes):
    """Write a plan with changed keys; return its path."""
    path = tmp_path / 'plan.json'
    path.write_text(json.dumps({**plan_document(plan), **changes}))
    return path


def test_round_trip(tmp_path):
    """Swaps, ends, wind, separation: all that the file says comes back, footprints included."""
    fleet = (
        dataclasses.replace(FLEET[0], is_open=True),
        dataclasses.replace(FLEET[1], endurance_s=260.0, battery_swap_s=60.0),
        dataclasses.replace(FLEET[2], end=FLEET[0].home, sensors=('gamma',)),
    )
    plan = plan_survey(
        request(vehicles=fleet, grid='rotated', wind_mps=(1.0, -1.0), distance_m=5.0)
    )
    found = read_plan(written(tmp_path, plan))
    assert found.request == plan.request
    assert plan_document(found) == plan_document(plan)
    assert check_plan(found) == []
    ours, theirs = (p.routes[1].viewpoints[0].footprint for p in (found, plan))
    assert max(distance_m(a, b) for a, b in zip(ours, theirs, strict=True)) < 1e-3


@pytest.mark.parametrize(
    ('changes', 'message'),
    [
        ({'format_version': 9}, 'has format 9, not 2: plan again'),
        ({'request': None}, 'plan.json: '),
    ],
)
def test_files_that_cannot_be_gone_on_with_are_refused(tmp_path, changes, message):
    """One line: the file and what is wrong with it."""
    plan = plan_survey(request())
    with pytest.raises(ValueError, match=message) as caught:
        read_plan(written(tmp_path, plan, **changes))
    assert '\n' not in str(caught.value)


def test_no_file_and_no_plan(tmp_path):
    """What is not there, and what is something else."""
    with pytest.raises(ValueError, match='No such file'):
        read_plan(tmp_path / 'none.json')
    (tmp_path / 'other.json').write_text('{}')
    with pytest.raises(ValueError, match="is no plan: it has no 'format_version'"):
        read_plan(tmp_path / 'other.json')
