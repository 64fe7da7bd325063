# SPDX-License-Identifier: Apache-2.0
"""The scene "field": five-cornered farmland with a dumped drum and a fragment in it.

Laid out about the centroid of the five-cornered field of the ROCSAFE demonstration; east and
north in metres.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from rocsafe_scene.scenery import farmland, plants, roads
from rocsafe_scene.scenery.light import shadow_of_box, shadow_of_discs
from rocsafe_scene.scenery.marks import Dots, Mark, Paint, Placing, disc, rectangle
from rocsafe_scene.scenery.outlines import blob, faded, generator, smooth_line
from rocsafe_scene.scenery.rolling_stock import cylinder
from rocsafe_scene.scenery.scene import Scene, Thing

_BORDER = ((-85.0, 262.0), (376.0, 142.0), (278.0, -227.0), (-243.0, -223.0), (-400.0, 85.0))
DRUM = (-205.7, 13.8)
FRAGMENT = (174.5, -142.0)
_TRACK = (
    (-420.0, -60.0),
    (-300, -40),
    (-180, -5),
    (-40, 10),
    (80, -20),
    (160, -110),
    (190, -190),
    (210, -280),
)


def field_scene(seed: int) -> Scene:
    """Return the scene; `seed` varies leaves, furrows and dirt, not the lay-out."""
    return Scene(tuple(_things(seed)))


def _things(seed: int) -> Iterator[Thing]:
    yield from _parcels(seed)
    yield roads.gravel_track('farm_track', _TRACK, 3.6, seed)
    yield from _walls(seed)
    yield from _dump(seed)
    yield from _farm(seed)
    yield from _trees(seed)


def _parcels(seed: int) -> Iterator[Thing]:
    yield farmland.meadow(
        'north_meadow',
        [(-85, 258), (150, 198), (80, 30), (-120, 40)],
        0.9,
        (98, 122, 56),
        seed,
        swath_m=5.0,
    )
    yield farmland.ploughed_field(
        'east_field', [(156, 196), (372, 140), (338, 10), (90, 28)], -0.26, seed
    )
    yield farmland.meadow(
        'west_meadow',
        [(-396, 84), (-94, 256), (-128, 36), (-300, -20)],
        0.5,
        (116, 132, 66),
        seed,
        swath_m=6.0,
    )
    yield farmland.meadow(
        'south_meadow',
        [(-240, -219), (130, -223), (140, -110), (-150, -16)],
        0.02,
        (84, 108, 50),
        seed,
        swath_m=4.0,
    )
    yield farmland.meadow(
        'corner_meadow',
        [(200, -222), (274, -222), (332, 0), (190, -90)],
        1.3,
        (126, 136, 72),
        seed,
        swath_m=4.5,
    )


def _walls(seed: int) -> Iterator[Thing]:
    closed = (*_BORDER, _BORDER[0])
    for number, (start, end) in enumerate(pairwise(closed)):
        if number % 2:
            yield stone_wall(f'wall_{number + 1}', (start, end), seed)
        else:
            yield plants.hedge(f'hedge_{number + 1}', [start, end], 2.2, 2.4, seed)
    inner = (
        ((150, 197), (84, 26)),
        ((-124, 38), (-92, 256)),
        ((-150, -14), (-242, -222)),
        ((84, 26), (340, 6)),
    )
    for number, line in enumerate(inner):
        yield stone_wall(f'inner_wall_{number + 1}', line, seed)


def stone_wall(
    name: str, ends: tuple[tuple[float, float], tuple[float, float]], seed: int
) -> Thing:
    """Return a dry stone wall, stone by stone."""
    rng = generator(seed, 51, len(name), ord(name[-1]))
    line = np.repeat(smooth_line(ends, 0.45), 2, axis=0)
    places = line + rng.normal(0.0, 0.16, line.shape)
    sizes = rng.uniform(0.16, 0.34, len(places))
    grey = rng.uniform(96.0, 176.0, (len(places), 1)) * np.array([[1.0, 0.99, 0.95]])
    stones = Dots(places, sizes, np.hstack([grey, np.full((len(places), 1), 90.0)]))
    east, north = line.mean(axis=0).tolist()
    return Thing(
        name=name,
        kind='wall',
        placing=Placing(east, north),
        size_m=(1.0, 1.0, 0.0),
        shadow=(shadow_of_discs(places, sizes, np.full(len(places), 0.9)),),
        body=(stones,),
    )


def barrel(name: str, placing: Placing, colour: tuple[int, int, int], *, is_lying: bool) -> Thing:
    """Return a 200 litre drum."""
    body: list[Mark]
    if is_lying:
        body = [*cylinder(placing, 0.92, 0.3, Paint(colour, 20))]
        shadow: Mark = shadow_of_box(placing, 0.9, 0.58, 0.58)
    else:
        centre = (placing.east_m, placing.north_m)
        body = [
            disc(centre, 0.31, Paint(colour, 20).lit(0.8)),
            disc(centre, 0.26, Paint(colour, 20).lit(1.1)),
        ]
        shadow = shadow_of_box(placing, 0.5, 0.5, 0.9)
    return Thing(
        name=name,
        kind='barrel',
        placing=placing,
        size_m=(0.9, 0.6, 0.6),
        colour=colour,
        shadow=(shadow,),
        body=tuple(body),
    )


def container(name: str, placing: Placing, colour: tuple[int, int, int]) -> Thing:
    """Return a 20 foot freight container."""
    paint = Paint(colour, 40)
    body: list[Mark] = [rectangle(placing, 6.06, 2.44, paint.lit(1.05))]
    for x in np.arange(-2.85, 2.9, 0.3).tolist():
        body.append(rectangle(placing.moved(x, 0.0), 0.1, 2.3, paint.lit(0.82)))
    for x in (-3.0, 3.0):
        body.append(rectangle(placing.moved(x, 0.0), 0.14, 2.44, paint.lit(0.6)))
    return Thing(
        name=name,
        kind='container',
        placing=placing,
        size_m=(6.06, 2.44, 2.6),
        colour=colour,
        shadow=(shadow_of_box(placing, 6.06, 2.44, 2.6),),
        body=tuple(body),
    )


def _dump(seed: int) -> Iterator[Thing]:
    rng = generator(seed, 52)
    stains = (('drum_stain', DRUM, 3.4), ('fragment_stain', FRAGMENT, 4.2))
    for name, (east, north), radius in stains:
        stain = faded(
            blob(rng, (east - 0.6, north - 0.8), (radius, 0.6 * radius), 0.7),
            Paint((78, 66, 40), 150, 0.75),
        )
        yield Thing(
            name=name,
            kind='stain',
            placing=Placing(east, north),
            size_m=(1.0, 1.0, 0.0),
            ground=(stain,),
        )
    east, north = DRUM
    yield barrel('drum', Placing(east, north, 0.5), (222, 184, 36), is_lying=True)
    yield barrel('drum_2', Placing(east + 1.6, north + 0.7), (40, 84, 150), is_lying=False)
    yield barrel('drum_3', Placing(east + 1.1, north - 1.3, 2.0), (150, 54, 40), is_lying=True)
    yield container('container_1', Placing(east + 9.0, north + 6.5, 0.3), (44, 92, 128))
    yield container('container_2', Placing(east + 7.5, north + 10.5, 0.22), (158, 74, 50))
    east, north = FRAGMENT
    yield barrel('fragment', Placing(east, north, 1.1), (190, 192, 188), is_lying=True)
    yield container('container_3', Placing(east - 14.0, north + 3.0, 1.9), (92, 110, 74))
    yield roads.car('abandoned_car', Placing(east + 6.0, north - 5.0, 2.3), (120, 56, 48))


def _farm(seed: int) -> Iterator[Thing]:
    yield farmland.yard('yard', [(-6, 16), (44, 10), (48, 52), (0, 58)])
    yield farmland.house('barn', Placing(14.0, 44.0, 0.12), 20.0, 11.0, is_tiled=True)
    yield farmland.house('shed', Placing(37.0, 36.0, 1.7), 12.0, 7.0)
    yield roads.lorry('farm_lorry', Placing(16.0, 26.0, 0.3), (46, 104, 62))
    yield farmland.sheep('flock_1', (-60.0, 130.0), 34, 16.0, seed)
    yield farmland.sheep('flock_2', (238.0, -120.0), 22, 11.0, seed)


def _trees(seed: int) -> Iterator[Thing]:
    rng = generator(seed, 53)
    closed = np.array([*_BORDER, _BORDER[0]])
    spots = []
    for start, end in pairwise(closed):
        for share in rng.uniform(0.03, 0.97, 7).tolist():
            spots.append(start + share * (end - start) + rng.normal(0.0, 3.0, 2))
    spots += [np.array([40.0, -70.0]) + rng.normal(0.0, 16.0, 2) for _ in range(12)]
    for number, spot in enumerate(spots):
        radius = rng.uniform(3.0, 5.8)
        colour = plants.PINE if number % 7 == 3 else plants.LEAVES[number % 4]
        east, north = spot.tolist()
        yield plants.tree(f'tree_{number + 1}', (east, north), radius, 2.2 * radius, seed, colour)
    for number, angle in enumerate(np.linspace(0.0, 2.0 * math.pi, 9).tolist()):
        place = (150.0 * math.cos(angle) - 20.0, 110.0 * math.sin(angle))
        colour = plants.BLOSSOM if number % 2 else plants.LEAVES[2]
        yield plants.shrubs(f'gorse_{number + 1}', place, 4.0, 14, seed, colour)
