# SPDX-License-Identifier: Apache-2.0
"""Times of legs that are kept: the same as those of legs flown one by one."""

import dataclasses

import numpy as np
import pytest

from rocsafe_planner.problem import fleet_problem, leg_times
from rocsafe_planner.routing.methods import METHODS
from rocsafe_planner.site.survey_site import survey_site

from .fleets import FLEET, request
from .terrains import terrain

HILLS = terrain(lambda east, north: 30.0 * np.sin(east / 60.0) * np.cos(north / 40.0))
WINDY = request(wind_mps=(3.0, -2.0))
HILLY = request(terrain=HILLS, height_agl_m=60.0)


@pytest.mark.slow
@pytest.mark.parametrize('survey', [WINDY, HILLY])
def test_kept_times_are_those_of_single_legs(monkeypatch, survey):
    """All legs at once, and each by itself, take the same time, for each of the vehicles."""
    problem = survey_site(survey).problem
    monkeypatch.setattr(fleet_problem, 'MOST_KEPT', 0)
    monkeypatch.setattr(leg_times, '_MOST_AT_ONCE', 1000)
    afresh = survey_site(survey).problem
    every = np.arange(len(problem.sites))
    for vehicle in range(len(FLEET)):
        kept = problem.legs_s(vehicle, every[:, None], every[None, :])
        for origin, target in ((0, 5), (5, 0), (len(every) - 1, 3), (2, 2)):
            one = afresh.legs_s(vehicle, np.array([origin]), np.array([target]))
            assert kept[origin, target] == pytest.approx(one[0], rel=1e-12, abs=1e-12)
            again = problem.legs_s(vehicle, np.array([origin]), np.array([target]))
            assert again[0] == kept[origin, target]


@pytest.mark.slow
def test_keeping_times_changes_no_route(monkeypatch):
    """Vehicles that need sensors fly the same routes whether times are kept or not."""
    able = tuple(
        dataclasses.replace(v, sensors=('lidar',) if k else ()) for k, v in enumerate(FLEET)
    )
    region = dataclasses.replace(HILLY.regions[0], sensors=('lidar',))
    survey = dataclasses.replace(HILLY, vehicles=able, regions=(region,))
    kept = METHODS['strips'](survey_site(survey).problem)
    monkeypatch.setattr(fleet_problem, 'MOST_KEPT', 0)
    assert METHODS['strips'](survey_site(survey).problem) == kept
