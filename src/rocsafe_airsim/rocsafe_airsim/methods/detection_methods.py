# SPDX-License-Identifier: Apache-2.0
"""Methods that tell which things a camera sees, and where."""

import fnmatch
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from rocsafe_airsim import images, values
from rocsafe_airsim.detections import Detection, detections
from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.access import Access, parameters, served
from rocsafe_airsim.methods.given import number
from rocsafe_airsim.vehicle import Vehicle

# AirSim's own.
RADIUS_M = 200.0
MOST_NAMES = 100
# Rows of the table of instances that are no things.
_NO_THINGS = frozenset({'sky', 'ground'})
Key = tuple[str, str, int]
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)


@dataclass(slots=True, kw_only=True)
class Filter:
    """Names that are looked for, with wild cards, and how far away."""

    names: list[str] = field(default_factory=list)
    radius_m: float = RADIUS_M

    def is_wanted(self, row: Mapping[str, Any]) -> bool:
        """Return whether an instance is looked for."""
        name = str(row['name'])
        is_thing = name not in _NO_THINGS
        return is_thing and any(
            fnmatch.fnmatchcase(name.lower(), each.lower()) for each in self.names
        )


class DetectionMethods:
    """Things in the image of a camera, by the instances that the engine draws."""

    def __init__(self, at: Access) -> None:
        self._at = at
        self._filters: dict[Key, Filter] = {}

    @served('simAddDetectionFilterMeshName')
    async def _sim_add_detection_filter_mesh_name(self, *call: Any) -> None:
        camera, kind, mesh, name, *_ = (*parameters(call, 3), '')
        names = self._filter(self._at.simulated(name), camera, kind).names
        if str(mesh) not in names:
            if len(names) >= MOST_NAMES:
                raise AirsimError(f'{len(names)} names are looked for already, which is the most')
            names.append(str(mesh))

    @served('simSetDetectionFilterRadius')
    async def _sim_set_detection_filter_radius(self, *call: Any) -> None:
        camera, kind, radius_cm, name, *_ = (*parameters(call, 3), '')
        radius_m = number(radius_cm, 'radius_cm', is_finite=False) / 100.0
        if not (math.isfinite(radius_m) and radius_m > 0.0):
            raise AirsimError(f'radius_cm is {100.0 * radius_m:g}: must be positive')
        self._filter(self._at.simulated(name), camera, kind).radius_m = radius_m

    @served('simClearDetectionMeshNames')
    async def _sim_clear_detection_mesh_names(self, *call: Any) -> None:
        camera, kind, name, *_ = (*parameters(call, 2), '')
        self._filter(self._at.simulated(name), camera, kind).names.clear()

    @served('simGetDetections')
    async def _sim_get_detections(self, *call: Any) -> list[values.Plain]:
        camera, kind, name, *_ = (*parameters(call, 2), '')
        vehicle = self._at.simulated(name)
        wanted = self._filter(vehicle, camera, kind)
        rows = [row for row in self._at.instances() if wanted.is_wanted(row)]
        if not rows:
            return []
        picture = await vehicle.look(self._at.camera(vehicle, camera), with_truth=True)
        if picture.depth_m is None or picture.labels is None:
            raise AirsimError('this camera is not drawn by an engine: sees no instances')
        found = detections(picture, {int(row['number']): str(row['name']) for row in rows})
        near = (each for each in found if each.distance_m <= wanted.radius_m)
        return [self._told(each) for each in near]

    def _filter(self, vehicle: Vehicle, camera: Any, kind: Any) -> Filter:
        own = self._at.camera(vehicle, camera)
        return self._filters.setdefault((vehicle.name, own, images.image_type(kind)), Filter())

    def _told(self, found: Detection) -> values.Plain:
        """Return a DetectionInfo."""
        left, top, right, bottom = found.box_px
        return {
            'name': found.name,
            'geo_point': values.geo_point(self._at.world.to_geodetic(found.place_enu)),
            'box2D': {
                'min': {'x_val': float(left), 'y_val': float(top)},
                'max': {'x_val': float(right), 'y_val': float(bottom)},
            },
            'box3D': {'min': values.vector(found.low_m), 'max': values.vector(found.high_m)},
            'relative_pose': values.pose(found.middle_m, _UPRIGHT),
        }
