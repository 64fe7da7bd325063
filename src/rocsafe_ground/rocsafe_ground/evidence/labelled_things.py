# SPDX-License-Identifier: Apache-2.0
"""Evidence points that labels propose: drums, flasks, wagons, markers."""

import numpy as np
from scipy.ndimage import center_of_mass, label

from rocsafe_geo.position import GeoPosition
from rocsafe_ground.drivable.labels import LabelMap
from rocsafe_ground.evidence.evidence_point import DEFAULT_DWELL_S, OBJECT, EvidencePoint

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


def labelled_things(
    labels: LabelMap, most: int, dwell_s: float = DEFAULT_DWELL_S
) -> list[EvidencePoint]:
    """Return up to `most` things, the worthiest first, of one kind the largest first.

    A vehicle stands at each for `dwell_s`.
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
            longitude, latitude = labels.bands.place_in('EPSG:4326', row, column)
            point = EvidencePoint(
                id=f'{name}-{number}',
                position=GeoPosition(latitude, longitude),
                kind=OBJECT,
                priority=worth,
                dwell_s=dwell_s,
                found_in=f'label {name}, {sizes[number]:.2f} m2',
            )
            found.append((-worth, -float(sizes[number]), point))
    return [point for _, _, point in sorted(found, key=lambda one: one[:2])[:most]]
