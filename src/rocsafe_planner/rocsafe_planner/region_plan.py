# SPDX-License-Identifier: Apache-2.0
"""A plan in one line: a region file and a number of drones."""

import math
from pathlib import Path
from typing import Any

from rocsafe_geo.limits import require_count
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.regions.area_files import read_areas
from rocsafe_planner.checked_planning import checked_plan
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import CoverageOptions
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle

CAMERA = PinholeCamera(math.radians(60.0), 640, 480)
"""Value of a request that names none."""


def plan_region(
    path: str | Path, drones: int = 3, height_agl_m: float = 32.0, **options: Any
) -> SurveyPlan:
    r"""Return the checked plan for the regions of a GeoJSON, KML, KMZ, QGroundControl or CSV file.

    Parameters
    ----------
    path
        Region file.
    drones
        Number of like drones at the first corner of the region, unless `options` has `vehicles`.
    height_agl_m
        Height of the camera above the ground, metres, unless `options` has `coverage`.
    options
        Other fields of `SurveyRequest`, e.g. `effort` or `exclusions`.

    Raises
    ------
    ValueError
        If the file or an option is wrong, in one line.
    PlannerError
        If there is no plan.

    Examples
    --------
    Two drones over a field of 1 ha, whose corners are in a CSV file:

    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> corners = 'latitude,longitude\n53.2800,-9.0600\n53.2809,-9.0600\n'
    >>> corners += '53.2809,-9.0585\n53.2800,-9.0585\n'
    >>> with TemporaryDirectory() as folder:
    ...     field = Path(folder, 'field.csv')
    ...     _ = field.write_text(corners)
    ...     plan = plan_region(field, drones=2)
    >>> [route.vehicle.name for route in plan.routes]
    ['rav1', 'rav2']
    >>> plan.lower_bound_s <= plan.makespan_s
    True
    """
    areas = read_areas(Path(path))
    require_count('drones', drones, 1, 1000)
    names = (f'rav{number}' for number in range(1, drones + 1))
    values = {
        'camera': CAMERA,
        'coverage': CoverageOptions(height_agl_m=height_agl_m),
        'vehicles': tuple(Vehicle(name=name, home=areas[0].boundary[0]) for name in names),
        **options,
    }
    regions = tuple(SurveyRegion(area=area) for area in areas)
    return checked_plan(SurveyRequest(regions=regions, **values))
