# SPDX-License-Identifier: Apache-2.0
"""The scene "derailment": a goods train off the rails, with a flask thrown beside the track.

Laid out in a frame whose x axis runs along the railway, turned from east so that it lies along
the region of the ROCSAFE demonstration; the flask lies at the origin.
"""

from collections.abc import Iterator

import numpy as np

from rocsafe_scene.scenery import farmland, railway, roads, rolling_stock
from rocsafe_scene.scenery.derailment_site import SITE, TORN_M, placing_at, point_at, rail_line
from rocsafe_scene.scenery.derailment_surroundings import fields, homestead, trees, ways
from rocsafe_scene.scenery.marks import Mark, Paint, polygon, stroke
from rocsafe_scene.scenery.outlines import blob, faded, generator, smooth_line
from rocsafe_scene.scenery.scene import Scene, Thing

_SILVER, _CREAM, _BLACK = (198, 200, 202), (222, 212, 186), (66, 66, 70)
_SCORCHED = Paint((34, 30, 28), 150, 0.82)
_EARTH = Paint((112, 86, 60), 190, 0.85)


def derailment_scene(seed: int) -> Scene:
    """Return the scene; `seed` varies leaves, furrows and dirt, not the lay-out."""
    return Scene(tuple(_things(seed)))


def _things(seed: int) -> Iterator[Thing]:
    yield from fields(seed)
    yield from ways(seed)
    yield from _wreck_ground(seed)
    yield from _train(seed)
    yield from _responders(seed)
    yield from homestead(seed)
    yield from trees(seed)


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
        outline = blob(rng, point_at(x, y), (long, wide), SITE.yaw_rad + yaw)
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
        placing=placing_at(15, 8),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(earth),
    )
    scorch: list[Mark] = []
    for place, radius in (
        (point_at(18, 15.5), 7.0),
        (point_at(22, 12), 4.5),
        (point_at(13, 17), 4.0),
    ):
        scorch.append(faded(blob(rng, place, (radius, 0.7 * radius), 1.0), _SCORCHED))
    yield Thing(
        name='scorched_ground',
        kind='scorch',
        placing=placing_at(18, 15),
        size_m=(1, 1, 0.0),
        ground=tuple(scorch),
    )
    yield railway.torn_rails('torn_rails', rail_line(), TORN_M, seed)
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
    spill = roads.puddles('spill', [(*point_at(x, y), r) for x, y, r in pools], sheen, seed)
    runs = (
        stroke(flow, 1.5, Paint((150, 142, 74), 90, 0.55, 0.3)),
        stroke(flow, 0.8, Paint((52, 34, 46), 25, 0.85, 0.2)),
    )
    glints = tuple(
        polygon(
            blob(
                rng,
                point_at(x + rng.normal(0, 0.5), y + rng.normal(0, 0.5)),
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
        placing=placing_at(18, 8),
        size_m=(1.0, 1.0, 0.0),
        ground=tuple(body),
    )


def _train(seed: int) -> Iterator[Thing]:
    line = rail_line()
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
    yield rolling_stock.tank_car('tank_car_1', placing_at(-11.2, 10.2, 9.0), _SILVER, seed)
    yield rolling_stock.flat_car('flat_car_1', placing_at(3.6, 6.8, -31.0), (4.2,), seed)
    yield rolling_stock.flask('flask_2', placing_at(0.0, 0.0, 38.0), seed)
    yield rolling_stock.tank_car(
        'tank_car_2', placing_at(17.0, 13.2, 58.0), _BLACK, seed, is_on_its_side=True
    )
    yield rolling_stock.tank_car(
        'tank_car_3', placing_at(30.5, 3.2, -52.0), _CREAM, seed, is_on_its_side=True
    )
    yield rolling_stock.flat_car('flat_car_2', placing_at(43.6, 11.0, 24.0), (-4.2, 3.9), seed)
    yield rolling_stock.tank_car('tank_car_4', placing_at(58.6, 9.6, -7.0), _SILVER, seed)
    yield rolling_stock.locomotive('locomotive', placing_at(77.5, 11.2, 4.2))


def _responders(seed: int) -> Iterator[Thing]:
    yield roads.fire_engine('fire_engine_1', placing_at(-31.0, -12.6, 2.0))
    yield roads.fire_engine('fire_engine_2', placing_at(-78.6, -27.0, 82.0))
    yield roads.fire_engine('fire_engine_3', placing_at(56.0, -14.6, 176.0))
    yield roads.ambulance('ambulance_1', placing_at(-77.9, -37.5, 83.0))
    yield roads.ambulance('ambulance_2', placing_at(61.5, -20.5, 95.0))
    yield roads.car('police_car_1', placing_at(-70.6, 26.0, 170.0), (232, 234, 236))
    yield roads.car('police_car_2', placing_at(-77.8, -9.0, 172.0), (232, 234, 236))
    yield roads.car('command_car', placing_at(41.0, -21.5, 20.0), (160, 30, 34))
    yield roads.lorry('equipment_lorry', placing_at(-82.0, -50.0, 83.0), (40, 80, 140))
    yield farmland.tent('command_tent', placing_at(49.5, -20.6, 4.0), (66, 104, 160))
    yield farmland.tent('decontamination_tent', placing_at(-17.0, -19.6, 6.0), (222, 170, 52))
    yield roads.people('crew_1', point_at(-24.0, -11.0), 6, seed)
    yield roads.people('crew_2', point_at(-12.0, -14.5), 5, seed)
    yield roads.people('crew_3', point_at(53.0, -14.0), 7, seed)
    yield roads.people('crew_4', point_at(-74.0, -18.0), 4, seed)
    yield roads.cordon(
        'cordon_south',
        SITE.to_world(
            [[-64, 2], [-44, -4], [-20, -8.5], [8, -9.6], [34, -9.0], [70, -6], [96, 2]]
        ),
    )
    yield roads.cordon(
        'cordon_north', SITE.to_world([[-60, 15], [-30, 19], [10, 27.5], [45, 25], [96, 21]])
    )
