# SPDX-License-Identifier: Apache-2.0
"""A plan in one line: a region file and a number of drones.

from rocsafe_planner.region_plan import plan_region
plan = plan_region('field.geojson', drones=5, budget_s=10.0)
print(plan.makespan_s, plan.gap_fraction)
"""

import math
from pathlib import Path
from typing import Any

from rocsafe_geo.limits import require_count
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area_files import read_areas
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.problem.survey_region import SurveyRegion
from rocsafe_planner.problem.vehicle import Vehicle
from rocsafe_planner.site.request import SurveyRequest

CAMERA = PinholeCamera(math.radians(60.0), 640, 480)
"""Of a request that names none."""


def plan_region(
    path: str | Path, drones: int = 3, height_agl_m: float = 32.0, **options: Any
) -> SurveyPlan:
    """Return the plan for the regions of a GeoJSON, KML, KMZ, QGroundControl or CSV file.

    Parameters
    ----------
    path
        Of the file.
    drones
        Alike, from the region's first corner; or name `vehicles` among the options.
    height_agl_m
        Of the camera above the ground.
    options
        Any other fields of `SurveyRequest`, e.g. `budget_s`, `objective`, `exclusions`.

    Raises
    ------
    ValueError
        If the file or an option is wrong, in one line.
    PlannerError
        If there is no plan.
    """
    areas = read_areas(Path(path))
    require_count('drones', drones, 1, 1000)
    values = {
        'camera': CAMERA,
        'vehicles': tuple(
            drone(f'rav{number}', areas[0].boundary[0]) for number in range(1, drones + 1)
        ),
        **options,
    }
    return plan_survey(
        SurveyRequest(
            regions=tuple(SurveyRegion(area=area) for area in areas),
            height_agl_m=height_agl_m,
            **values,
        )
    )


def drone(name: str, home: GeoPosition) -> Vehicle:
    """Return a small drone that stands at `home`."""
    return Vehicle(
        name=name,
        home=home,
        cruise_speed_mps=5.0,
        acceleration_mps2=2.0,
        climb_rate_mps=2.5,
        descent_rate_mps=1.5,
        hover_s=1.0,
        endurance_s=1350.0,
    )
