# SPDX-License-Identifier: Apache-2.0
"""Around the derailment: fields, roads, a farm, trees."""

from collections.abc import Iterator

import numpy as np

from rocsafe_scene.scenery import farmland, plants, railway, roads
from rocsafe_scene.scenery.derailment_site import (
    SITE,
    TORN_M,
    placing_at,
    point_at,
    rail_line,
    rail_y_m,
)
from rocsafe_scene.scenery.outlines import generator
from rocsafe_scene.scenery.scene import Thing

# x, y and radius; x, y.
_TREES = (
    (-48.0, 26.0, 4.0),
    (-38, 29, 3.2),
    (70, 31, 4.4),
    (82, 30, 3.4),
    (104, 29, 4.8),
    (-116, 34, 4.6),
    (-118, 47, 5.2),
    (-95, 57, 4.2),
    (-79, 60, 3.6),
    (-116, -16, 4.4),
    (-96, -40, 3.8),
    (-118, -30, 5.0),
    (2, -50, 4.3),
    (-22, -52, 3.6),
    (30, -49, 3.2),
    (88, -48, 4.6),
    (98, -52, 5.4),
    (110, -47, 4.2),
    (104, -60, 4.8),
    (92, -60, 3.8),
    (116, -58, 5.0),
    (-60, -52, 4.0),
    (-48, -55, 3.4),
    (78, -54, 3.4),
    (-76, 33, 3.0),
)
_SHRUBS = ((66.0, -8.0), (84, 3), (-52, 1), (-58, -6), (26, -33), (60, 18), (-36, 16.5), (98, 15))


def fields(seed: int) -> Iterator[Thing]:
    """Yield fields and meadows."""
    yield farmland.ploughed_field(
        'north_field',
        SITE.to_world([[-46, 21], [150, 30], [150, 108], [-36, 108]]),
        SITE.yaw_rad + 0.06,
        seed,
    )
    yield farmland.meadow(
        'west_pasture',
        SITE.to_world([[-190, 16], [-72, 16], [-58, 110], [-190, 110]]),
        SITE.yaw_rad + 1.3,
        (96, 118, 56),
        seed,
        swath_m=5.0,
    )
    yield farmland.meadow(
        'south_meadow',
        SITE.to_world([[-64, -17], [150, -15], [150, -36], [-68, -38]]),
        SITE.yaw_rad,
        (104, 126, 62),
        seed,
    )
    yield farmland.meadow(
        'river_meadow',
        SITE.to_world([[-70, -50], [150, -47], [150, -110], [-80, -110]]),
        SITE.yaw_rad - 0.5,
        (78, 98, 52),
        seed,
        swath_m=7.0,
    )
    yield farmland.meadow(
        'west_meadow',
        SITE.to_world([[-190, -52], [-84, -50], [-92, -110], [-190, -110]]),
        SITE.yaw_rad + 0.2,
        (120, 132, 70),
        seed,
    )


def ways(seed: int) -> Iterator[Thing]:
    """Yield stream, roads and the railway."""
    yield roads.stream(
        'stream',
        SITE.to_world(
            [
                [-200, -46],
                [-150, -40],
                [-110, -47],
                [-70, -43],
                [-30, -47],
                [10, -41],
                [50, -45],
                [95, -40],
                [140, -44],
                [200, -38],
            ]
        ),
        2.4,
        seed,
    )
    yield roads.gravel_track(
        'access_track',
        SITE.to_world(
            [[-73, -14], [-50, -12.5], [-10, -13.5], [30, -12], [62, -13], [90, -10], [200, -6]]
        ),
        3.4,
        seed,
    )
    yield farmland.yard(
        'turning_place',
        SITE.to_world([[38, -25], [66, -24], [67, -12], [36, -11.5]]),
        (164, 152, 128),
    )
    yield roads.road(
        'road',
        SITE.to_world([[-92, -130], [-84, -70], [-77, -20], [-70, 20], [-60, 70], [-52, 130]]),
        6.2,
        seed,
    )
    line = rail_line()
    yield railway.track('railway', line, (TORN_M,), seed)
    crossing = placing_at(-72.5, rail_y_m(-72.5), 0.0)
    yield Thing(
        name='level_crossing',
        kind='level_crossing',
        placing=crossing,
        size_m=(7.0, 4.4, 0.0),
        ground=railway.level_crossing(crossing, 7.6),
    )


def homestead(seed: int) -> Iterator[Thing]:
    """Yield the farm and the cottage."""
    yield farmland.yard(
        'farm_yard',
        SITE.to_world([[-108, 28], [-73, 30], [-71, 36], [-88, 40], [-90, 52], [-110, 50]]),
    )
    yield farmland.house('farm_house', placing_at(-100.5, 44.0, 4.0), 14.0, 8.6)
    yield farmland.house('barn', placing_at(-83.0, 47.5, 95.0), 17.0, 10.0, is_tiled=True)
    yield farmland.house('shed', placing_at(-103.5, 31.5, 4.0), 8.0, 5.0)
    yield farmland.house('cottage', placing_at(-104.0, -22.0, 12.0), 11.0, 7.6)
    yield farmland.yard(
        'cottage_drive', SITE.to_world([[-97, -25], [-79, -28], [-78.4, -24], [-96, -20]])
    )
    yield roads.car('farm_car', placing_at(-93.0, 36.5, 60.0), (48, 92, 60))
    yield roads.car('cottage_car', placing_at(-90.0, -24.0, 170.0), (150, 156, 164))
    yield farmland.sheep('flock', point_at(-104.0, 76.0), 26, 10.0, seed)


def trees(seed: int) -> Iterator[Thing]:
    """Yield hedges, trees and shrubs."""
    for name, line in (
        ('hedge_north', [[-44, 20], [0, 31.5], [40, 30], [90, 25.5], [150, 29]]),
        ('hedge_road_west', [[-78, 19], [-75.5, 27]]),
        ('hedge_road_north', [[-71, 42], [-64, 78], [-60, 112]]),
        ('hedge_road_east', [[-63, 23], [-55, 62], [-48, 108]]),
        ('hedge_garden', [[-112, 26], [-112, 53], [-92, 56], [-90, 53]]),
        ('hedge_cottage', [[-114, -12], [-112, -33], [-96, -36], [-82, -34]]),
        ('hedge_road_south', [[-88.5, -56], [-92, -86], [-96, -112]]),
    ):
        yield plants.hedge(name, SITE.to_world(np.array(line, float)), 1.9, 2.2, seed)
    rng = generator(seed, 44)
    wood = zip(
        rng.uniform(85, 150, 26).tolist(),
        rng.uniform(-105, -62, 26).tolist(),
        rng.uniform(3.0, 5.6, 26).tolist(),
        strict=True,
    )
    for number, (x, y, radius) in enumerate([*_TREES, *wood]):
        colour = plants.PINE if number % 6 == 5 else plants.LEAVES[number % 4]
        height = radius * rng.uniform(1.9, 2.6)
        yield plants.tree(
            f'tree_{number + 1}', point_at(x, y), radius, float(height), seed, colour
        )
    for number, (x, y) in enumerate(_SHRUBS):
        colour = plants.BLOSSOM if number % 3 == 0 else plants.LEAVES[3]
        yield plants.shrubs(f'shrubs_{number + 1}', point_at(x, y), 2.4, 9, seed, colour)
