# SPDX-License-Identifier: Apache-2.0
"""Options of the planner node."""

from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.limits import require_count
from rocsafe_geo.option import option
from rocsafe_planner.plan.plan_json import further_folder
from rocsafe_planner.plan.survey_options import (
    GRIDS,
    MAX_VIEWPOINTS_LIMIT,
    METHODS,
    USUAL_VIEWPOINTS_LIMIT,
    require_one_of,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannerOptions:
    """What a request leaves open; one ROS parameter a field."""

    default_method: str = option(
        METHODS[0], f'routing method of a request that names none: {", ".join(METHODS)}'
    )
    grid: str = option(GRIDS[0], f'circum-rectangle of the region: {", ".join(GRIDS)}')
    max_viewpoints: int = option(
        USUAL_VIEWPOINTS_LIMIT, 'largest number of viewpoints of any plan', 1, MAX_VIEWPOINTS_LIMIT
    )
    export_directory: str = option(
        '', 'folder for plan.json, .geojson, .kml and plan-<vehicle>.plan; empty: none'
    )

    def __post_init__(self) -> None:
        require_one_of('default_method', self.default_method, METHODS)
        require_one_of('grid', self.grid, GRIDS)
        require_count('max_viewpoints', self.max_viewpoints, 1, MAX_VIEWPOINTS_LIMIT)

    def export_folder(self, plan_id: str, is_further: bool) -> Path:
        """Return the folder for the files of a plan; one of given viewpoints has its own."""
        folder = Path(self.export_directory)
        return further_folder(folder, plan_id) if is_further else folder

    def exported(self, plan_id: str) -> tuple[Path, ...]:
        """Return the files in which a plan may have been exported."""
        if not self.export_directory:
            return ()
        folders = (self.export_folder(plan_id, is_further) for is_further in (False, True))
        return tuple(folder / 'plan.json' for folder in folders)
