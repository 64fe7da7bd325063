# SPDX-License-Identifier: Apache-2.0
"""Fleets, areas and requests that the planner's tests share."""

import math

import numpy as np

from rocsafe_geo.motion.autopilot import DIRECT
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.problem.fleet_problem import FleetProblem
from rocsafe_planner.problem.survey_region import SurveyRegion
from rocsafe_planner.problem.vehicle import Vehicle
from rocsafe_planner.site.request import SurveyRequest

# The seed system's survey rectangle, its field and its drone starts, in Galway.
RECTANGLE = SurveyArea(
    tuple(
        GeoPosition(*place)
        for place in (
            (53.27959959, -9.0617270785),
            (53.2805257315, -9.0621271428),
            (53.2801009832, -9.0648776011),
            (53.2791748417, -9.0644775368),
        )
    ),
    name='rectangle',
)
FIELD = SurveyArea(
    tuple(
        GeoPosition(*place)
        for place in (
            (53.28323, -9.062691),
            (53.28215, -9.055781),
            (53.27884, -9.057240),
            (53.27887, -9.065051),
            (53.28164, -9.067411),
        )
    ),
    name='field',
)
STARTS = ((53.2800, -9.0700), (53.2860, -9.0588), (53.2798, -9.0565))
CAMERA = PinholeCamera(math.radians(60.0), 640, 480)


def vehicle(name='rav1', home=STARTS[0], altitude=12.0, **changes):
    """Return a vehicle of ordinary performance, whose times can be worked by hand."""
    values = {
        'cruise_speed_mps': 8.0,
        'acceleration_mps2': 2.5,
        'climb_rate_mps': 3.0,
        'descent_rate_mps': 2.0,
        'hover_s': 2.0,
        'endurance_s': 10_000.0,
        'autopilot': DIRECT,
        **changes,
    }
    return Vehicle(name=name, home=GeoPosition(*home, altitude), **values)


FLEET = tuple(vehicle(f'rav{number}', home) for number, home in enumerate(STARTS, start=1))


def request(**changes):
    """Return the derailment mission's request."""
    regions = (SurveyRegion(area=changes.pop('area', RECTANGLE)),)
    return SurveyRequest(
        **{
            'regions': regions,
            'camera': CAMERA,
            'vehicles': FLEET,
            'height_agl_m': 32.0,
            'method': 'paper_greedy',
            **changes,
        }
    )


def problem(points, homes, vehicles=None, height=10.0):
    """Return a routing problem in the plane."""
    vehicles = vehicles or tuple(vehicle(f'rav{k}') for k in range(len(homes)))
    return FleetProblem(
        vehicles=vehicles,
        homes=np.array(homes, float),
        points=np.array(points, float),
        height_m=height,
    )
