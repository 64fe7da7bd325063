# SPDX-License-Identifier: Apache-2.0
"""Evidence points that labels propose: drums, flasks, wagons, markers."""

import numpy as np
from scipy.ndimage import center_of_mass, label

from rocsafe_ground.drivable.labels import LabelMap
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.evidence.evidence_point import OBJECT, EvidencePoint

# Classes that are evidence, and how much each is worth: a flask holds a source, a drum may leak.
WORTH = {
    'flask': 1.0,
    'drum': 0.7,
    'evidence': 0.7,
    'tank_car': 0.5,
    'road_tanker': 0.5,
    'box_car': 0.3,
}
# A smaller patch is an error of labels at an edge.
LEAST_AREA_M2 = 0.15


def labelled_things(labels: LabelMap, grid: RouteGrid, most: int) -> list[EvidencePoint]:
    """Return up to `most` things, the worthiest first, of one kind the largest first.

    `grid` is that of a route on the same ground; its frame gives the places.
    """
    found: list[tuple[float, float, EvidencePoint]] = []
    pixel_m2 = labels.bands.pixel_m**2
    for name, worth in WORTH.items():
        patches, count = label(labels.shows(name), structure=np.ones((3, 3)))
        sizes = np.bincount(patches.ravel(), minlength=count + 1) * pixel_m2
        middles = center_of_mass(patches > 0, patches, range(1, count + 1)) if count else []
        for number, (row, column) in enumerate(middles, 1):
            if sizes[number] < LEAST_AREA_M2:
                continue
            east, north = labels.bands.place_in(grid.projection, row, column)
            point = EvidencePoint(
                id=f'{name}-{number}',
                position=grid.position_at(east, north),
                kind=OBJECT,
                priority=worth,
                found_in=f'label {name}, {sizes[number]:.2f} m2',
            )
            found.append((-worth, -float(sizes[number]), point))
    return [point for _, _, point in sorted(found, key=lambda one: one[:2])[:most]]
