# SPDX-License-Identifier: Apache-2.0
"""The scene "derailment": a goods train off the rails, with a flask thrown beside the track.

Laid out in a frame whose x axis runs along the railway, turned from east so that it lies along
the region of the ROCSAFE demonstration; the flask lies at the origin.
"""

import math
from collections.abc import Iterator

import numpy as np

from rocsafe_sim.scenery import farmland, plants, railway, roads, rolling_stock
from rocsafe_sim.scenery.marks import Mark, Paint, Placing, Points, polygon, stroke
from rocsafe_sim.scenery.outlines import blob, faded, generator, smooth_line
from rocsafe_sim.scenery.scene import Scene, Thing

SITE = Placing(0.0, 0.0, math.radians(14.4))
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
# Torn up, metres along the track.
_GAP_M = (178.0, 246.0)
_SILVER, _CREAM, _BLACK = (198, 200, 202), (222, 212, 186), (66, 66, 70)
_SCORCHED = Paint((34, 30, 28), 150, 0.82)
_EARTH = Paint((112, 86, 60), 190, 0.85)


def derailment_scene(seed: int) -> Scene:
    """Return the scene; `seed` varies leaves, furrows and dirt, not the lay-out."""
    return Scene(tuple(_things(seed)))


def _things(seed: int) -> Iterator[Thing]:
    yield from _fields(seed)
    yield from _ways(seed)
    yield from _wreck_ground(seed)
    yield from _train(seed)
    yield from _responders(seed)
    yield from _homestead(seed)
    yield from _trees(seed)


def _at(x: float, y: float, yaw_deg: float = 0.0) -> Placing:
    return SITE.moved(x, y, math.radians(yaw_deg))


def _xy(x: float, y: float) -> tuple[float, float]:
    placing = SITE.moved(x, y)
    return placing.east_m, placing.north_m


def _rail_line() -> Points:
    x = np.arange(-190.0, 191.0, 4.0)
    return SITE.to_world(np.column_stack([x, 8.0 + 0.00045 * x**2]))


def _rail_y(x: float) -> float:
    return 8.0 + 0.00045 * x * x


def _fields(seed: int) -> Iterator[Thing]:
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


def _ways(seed: int) -> Iterator[Thing]:
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
    line = _rail_line()
    yield railway.track('railway', line, (_GAP_M,), seed)
    crossing = _at(-72.5, _rail_y(-72.5), 0.0)
    yield Thing(
        name='level_crossing',
        kind='level_crossing',
        placing=crossing,
        size_m=(7.0, 4.4, 0.0),
        ground=railway.level_crossing(crossing, 7.6),
    )


def _wreck_ground(seed: int) -> Iterator[Thing]:
    rng = generator(seed, 41)
    earth: list[Mark] = []
    for x, y, long, wide, yaw in (
        (-8, 9, 13, 4, 0.1),
        (8, 5, 13, 6, -0.5),
        (22, 11, 12, 5, 0.8),
        (33, 5, 12, 5, -0.3),
        (46, 10, 12, 5, 0.4),
        (3, 1, 8, 4, -0.7),
    ):
        outline = blob(rng, _xy(x, y), (long, wide), SITE.yaw_rad + yaw)
        earth.append(faded(outline, _EARTH, spread=0.35))
    for start, end in (
        ((-26, 8.6), (-6, 12)),
        ((-10, 8), (6, 1.5)),
        ((10, 7), (24, 14)),
        ((14, 8), (31, 1)),
        ((28, 8), (48, 13)),
        ((5, 6), (1, 1.2)),
    ):
        middle = np.add(start, end) / 2.0 + rng.normal(0.0, 1.0, 2)
        gouge = smooth_line(SITE.to_world(np.array([start, middle, end])), 1.0)
        earth.append(stroke(gouge, rng.uniform(0.8, 1.5), Paint((84, 62, 44), 200, 0.8, 0.3)))
    yield Thing(
        name='torn_earth',
        kind='soil',
        placing=_at(15, 8),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(earth),
    )
    scorch: list[Mark] = []
    for place, radius in ((_xy(18, 15.5), 7.0), (_xy(22, 12), 4.5), (_xy(13, 17), 4.0)):
        scorch.append(faded(blob(rng, place, (radius, 0.7 * radius), 1.0), _SCORCHED))
    yield Thing(
        name='scorched_ground',
        kind='scorch',
        placing=_at(18, 15),
        size_m=(1, 1, 0.0),
        ground=tuple(scorch),
    )
    yield railway.torn_rails('torn_rails', _rail_line(), _GAP_M, seed)
    yield _spill(seed)
    yield _debris(rng)


def _spill(seed: int) -> Thing:
    pools = [
        (35.0, -1.5, 3.0),
        (36.5, -4.5, 2.4),
        (36.0, -8.0, 1.9),
        (37.5, -11.5, 1.7),
        (38.5, -16.0, 1.4),
        (40.0, -21.0, 1.2),
        (39.5, -26.0, 1.3),
        (41.0, -31.0, 1.1),
        (42.0, -36.0, 1.3),
        (43.0, -40.5, 1.8),
    ]
    flow = smooth_line(SITE.to_world([pool[:2] for pool in pools]), 0.8)
    rng = generator(seed, 43)
    flow = flow + rng.normal(0.0, 0.09, flow.shape)
    sheen = Paint((52, 34, 46), 25, 0.8)
    spill = roads.puddles('spill', [(*_xy(x, y), r) for x, y, r in pools], sheen, seed)
    runs = (
        stroke(flow, 1.5, Paint((150, 142, 74), 90, 0.55, 0.3)),
        stroke(flow, 0.8, Paint((52, 34, 46), 25, 0.85, 0.2)),
    )
    glints = tuple(
        polygon(
            blob(
                rng,
                _xy(x + rng.normal(0, 0.5), y + rng.normal(0, 0.5)),
                (0.5 * r, 0.16 * r),
                rng.uniform(0, 3),
            ),
            Paint(colour, 10, 0.35, 0.1),
        )
        for x, y, r in pools[:6]
        for colour in ((110, 90, 190), (70, 150, 150), (190, 150, 90))
    )
    return Thing(
        name='spill',
        kind='spill',
        placing=spill.placing,
        size_m=spill.size_m,
        ground=(*runs, *spill.ground, *glints),
    )


def _debris(rng: np.random.Generator) -> Thing:
    colours = ((70, 66, 62), (150, 146, 140), (124, 82, 54), (196, 150, 60), (180, 182, 184))
    body: list[Mark] = []
    for _ in range(130):
        x, y = rng.normal(18.0, 17.0), rng.normal(8.0, 5.5)
        size = rng.uniform(0.1, 0.55)
        placing = SITE.moved(x, y, rng.uniform(0.0, 3.0))
        corners = placing.to_world(rng.uniform(-size, size, (4, 2)))
        body.append(polygon(corners, Paint(colours[int(rng.integers(5))], 40)))
    return Thing(
        name='debris',
        kind='debris',
        placing=_at(18, 8),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(body),
    )


def _train(seed: int) -> Iterator[Thing]:
    line = _rail_line()
    for number, (x, colour) in enumerate(
        (
            (-55.5, (134, 74, 52)),
            (-41.0, (120, 82, 58)),
            (-26.5, (92, 96, 84)),
        )
    ):
        yield rolling_stock.box_car(
            f'box_car_{number + 1}', railway.placing_on(line, 190.0 + x), colour, seed
        )
    yield rolling_stock.tank_car('tank_car_1', _at(-11.2, 10.2, 9.0), _SILVER, seed)
    yield rolling_stock.flat_car('flat_car_1', _at(3.6, 6.8, -31.0), (4.2,), seed)
    yield rolling_stock.flask('flask_2', _at(0.0, 0.0, 38.0), seed)
    yield rolling_stock.tank_car(
        'tank_car_2', _at(17.0, 13.2, 58.0), _BLACK, seed, is_on_its_side=True
    )
    yield rolling_stock.tank_car(
        'tank_car_3', _at(30.5, 3.2, -52.0), _CREAM, seed, is_on_its_side=True
    )
    yield rolling_stock.flat_car('flat_car_2', _at(43.6, 11.0, 24.0), (-4.2, 3.9), seed)
    yield rolling_stock.tank_car('tank_car_4', _at(58.6, 9.6, -7.0), _SILVER, seed)
    yield rolling_stock.locomotive('locomotive', _at(77.5, 11.2, 4.2))


def _responders(seed: int) -> Iterator[Thing]:
    yield roads.fire_engine('fire_engine_1', _at(-31.0, -12.6, 2.0))
    yield roads.fire_engine('fire_engine_2', _at(-78.6, -27.0, 82.0))
    yield roads.fire_engine('fire_engine_3', _at(56.0, -14.6, 176.0))
    yield roads.ambulance('ambulance_1', _at(-77.9, -37.5, 83.0))
    yield roads.ambulance('ambulance_2', _at(61.5, -20.5, 95.0))
    yield roads.car('police_car_1', _at(-70.6, 26.0, 170.0), (232, 234, 236))
    yield roads.car('police_car_2', _at(-77.8, -9.0, 172.0), (232, 234, 236))
    yield roads.car('command_car', _at(41.0, -21.5, 20.0), (160, 30, 34))
    yield roads.lorry('equipment_lorry', _at(-82.0, -50.0, 83.0), (40, 80, 140))
    yield farmland.tent('command_tent', _at(49.5, -20.6, 4.0), (66, 104, 160))
    yield farmland.tent('decontamination_tent', _at(-17.0, -19.6, 6.0), (222, 170, 52))
    yield roads.people('crew_1', _xy(-24.0, -11.0), 6, seed)
    yield roads.people('crew_2', _xy(-12.0, -14.5), 5, seed)
    yield roads.people('crew_3', _xy(53.0, -14.0), 7, seed)
    yield roads.people('crew_4', _xy(-74.0, -18.0), 4, seed)
    yield roads.cordon(
        'cordon_south',
        SITE.to_world(
            [[-64, 2], [-44, -4], [-20, -8.5], [8, -9.6], [34, -9.0], [70, -6], [96, 2]]
        ),
    )
    yield roads.cordon(
        'cordon_north', SITE.to_world([[-60, 15], [-30, 19], [10, 27.5], [45, 25], [96, 21]])
    )


def _homestead(seed: int) -> Iterator[Thing]:
    yield farmland.yard(
        'farm_yard',
        SITE.to_world([[-108, 28], [-73, 30], [-71, 36], [-88, 40], [-90, 52], [-110, 50]]),
    )
    yield farmland.house('farm_house', _at(-100.5, 44.0, 4.0), 14.0, 8.6)
    yield farmland.house('barn', _at(-83.0, 47.5, 95.0), 17.0, 10.0, is_tiled=True)
    yield farmland.house('shed', _at(-103.5, 31.5, 4.0), 8.0, 5.0)
    yield farmland.house('cottage', _at(-104.0, -22.0, 12.0), 11.0, 7.6)
    yield farmland.yard(
        'cottage_drive', SITE.to_world([[-97, -25], [-79, -28], [-78.4, -24], [-96, -20]])
    )
    yield roads.car('farm_car', _at(-93.0, 36.5, 60.0), (48, 92, 60))
    yield roads.car('cottage_car', _at(-90.0, -24.0, 170.0), (150, 156, 164))
    yield farmland.sheep('flock', _xy(-104.0, 76.0), 26, 10.0, seed)


def _trees(seed: int) -> Iterator[Thing]:
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
        yield plants.tree(f'tree_{number + 1}', _xy(x, y), radius, float(height), seed, colour)
    for number, (x, y) in enumerate(_SHRUBS):
        colour = plants.BLOSSOM if number % 3 == 0 else plants.LEAVES[3]
        yield plants.shrubs(f'shrubs_{number + 1}', _xy(x, y), 2.4, 9, seed, colour)
