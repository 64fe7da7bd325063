# SPDX-License-Identifier: Apache-2.0
"""Flight time that the first plan leaves for the rounds that agents fly after the survey."""

import math

import numpy as np

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.position import distance_m
from rocsafe_scenario.blocks.vehicles import VehicleBlock
from rocsafe_scenario.scenario import Scenario

MOST_OF_BATTERY = 0.5
"""Largest part of the usable flight time that is left."""
_WAYS = 16


def planned_endurance_s(scenario: Scenario, vehicle: VehicleBlock) -> float:
    """Return the flight time that the first plan may use of the battery of a vehicle."""
    usable_s = vehicle.usable_endurance_s
    return usable_s - min(search_reserve_s(scenario, vehicle), MOST_OF_BATTERY * usable_s)


def search_reserve_s(scenario: Scenario, vehicle: VehicleBlock) -> float:
    """Return how long a vehicle flies at most in all rounds that its fleet may fly.

    In each it flies from home to its share of the places, which are in the region, farthest from
    each other, and back. Not in the reserve: detours around exclusions, and shares of lost
    vehicles. 0 without agents, without rounds, and where batteries are changed.
    """
    search = scenario.radiation.search
    if not (scenario.fleet.agents and search.extra_rounds) or vehicle.battery_swap_s is not None:
        return 0.0
    corners = scenario.area().boundary
    home = scenario.ground_position(vehicle.home)
    share = math.ceil(search.viewpoints_a_round / len(scenario.vehicles))
    out_m = max(distance_m(home, corner) for corner in corners)
    across_m = max(distance_m(a, b) for a in corners for b in corners)
    height_m = scenario.survey.height_agl_m
    if scenario.survey.separation.by == 'reserved':
        height_m += scenario.survey.separation.distance_m * (len(scenario.vehicles) - 1)
    performance = _performance(scenario, vehicle)
    ways_s = 2.0 * _slowest_s(performance, out_m)
    ways_s += (share - 1) * _slowest_s(performance, across_m)
    vertical_s = performance.ascent_s(height_m) + performance.descent_s(height_m)
    return search.extra_rounds * (vertical_s + ways_s + share * vehicle.hover_s)


def _performance(scenario: Scenario, vehicle: VehicleBlock) -> Performance:
    rates = {'cruise_speed_mps', 'acceleration_mps2', 'climb_rate_mps', 'descent_rate_mps'}
    return Performance(
        **vehicle.model_dump(include=rates),
        autopilot=Autopilot(**vehicle.autopilot.model_dump()),
        wind_mps=scenario.survey.airspace.wind_mps,
    )


def _slowest_s(performance: Performance, way_m: float) -> float:
    """Return the time of a leg of a length in the direction that takes longest."""
    angles = np.linspace(0.0, 2.0 * math.pi, _WAYS, endpoint=False)
    ways = way_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return float(performance.legs_s(ways).max())
