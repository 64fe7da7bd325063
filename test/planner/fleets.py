# SPDX-License-Identifier: Apache-2.0
"""Fleets, areas and requests that the planner's tests share."""

import dataclasses
import math

import numpy as np

from rocsafe_geo.motion.autopilot import DIRECT
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import (
    AirspaceOptions,
    Continuation,
    CoverageOptions,
    Effort,
    SeparationOptions,
)
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.problem.fleet_problem import FleetProblem

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


GROUPS = {
    'coverage': CoverageOptions,
    'airspace': AirspaceOptions,
    'separation': SeparationOptions,
    'effort': Effort,
    'continuation': Continuation,
}


def request(**changes):
    """Return the derailment mission's request, without separation.

    `changes` name fields of it or of its values.
    """
    base = SurveyRequest(
        regions=(SurveyRegion(area=changes.pop('area', RECTANGLE)),),
        camera=CAMERA,
        vehicles=FLEET,
        coverage=CoverageOptions(height_agl_m=32.0, grid='axis_aligned'),
        separation=SeparationOptions(distance_m=0.0, by='delay'),
        effort=Effort(method='paper_greedy'),
    )
    return changed(base, **changes)


def changed(wish, **changes):
    """Return a request with other values, named by their own field, e.g. ``budget_s``."""
    values = {}
    for group, kind in GROUPS.items():
        names = {field.name for field in dataclasses.fields(kind)} & set(changes)
        inner = {name: changes.pop(name) for name in names}
        if inner:
            values[group] = dataclasses.replace(getattr(wish, group), **inner)
    return dataclasses.replace(wish, **values, **changes)


def problem(points, homes, vehicles=None, height=10.0):
    """Return a routing problem in the plane."""
    vehicles = vehicles or tuple(vehicle(f'rav{k}') for k in range(len(homes)))
    return FleetProblem(
        vehicles=vehicles,
        homes=np.array(homes, float),
        points=np.array(points, float),
        height_m=height,
    )
