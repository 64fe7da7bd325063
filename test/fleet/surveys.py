# SPDX-License-Identifier: Apache-2.0
"""Small surveys and fleets in simulated time for tests."""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np

from rocsafe_fleet.agreement.fleet_plan import SharedPlans
from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.trial import Trial, TrialOptions, planner_of
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import CoverageOptions, Effort, SeparationOptions
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.planning import plan_survey

CORNER = GeoPosition(53.28, -9.06, 10.0)
# A spacing of 20 m both ways.
CAMERA = PinholeCamera(2.0 * math.atan(15.0 / 32.0), 1000, 1000)


@lru_cache
def survey(fleet: int = 4, side: int = 6) -> SurveyPlan:
    """Return the plan of a square of `side` by `side` photographs for so many vehicles."""
    size = 20.0 * side
    corners = ((0, 0), (size, 0), (size, size), (0, size))
    area = SurveyArea(tuple(offset(CORNER, east - 10, north - 10) for east, north in corners))
    homes = [offset(CORNER, 15.0 * k, -30.0) for k in range(fleet)]
    return plan_survey(
        SurveyRequest(
            regions=(SurveyRegion(area=area),),
            camera=CAMERA,
            vehicles=tuple(Vehicle(name=f'rav{k}', home=home) for k, home in enumerate(homes)),
            coverage=CoverageOptions(height_agl_m=32.0),
            separation=SeparationOptions(by='reserved'),
            effort=Effort(proposals=10_000),
        )
    )


@lru_cache
def plans(plan: int = 4, side: int = 6) -> SharedPlans:
    """Return the plans of epochs of a survey, which its trials share."""
    return SharedPlans(planner_of(survey(plan, side)))


def trial(
    seed: int = 0, fleet: int = 4, radio: RadioOptions | None = None, side: int = 6
) -> Trial:
    """Return a fleet that is about to take off."""
    options = TrialOptions(radio=radio or RadioOptions(), step_s=0.2, longest_s=1500.0)
    random = np.random.default_rng(seed)
    return Trial(survey(fleet, side), options, random, plans(fleet, side))


def after(time_s: float) -> Callable[[Trial], bool]:
    """Return whether a trial has come to a time."""
    return lambda one: one.now_s >= time_s
