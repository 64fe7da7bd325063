# SPDX-License-Identifier: Apache-2.0
"""Variants of a scene: other weather and sun, small objects in other places."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import datetime, timedelta

import numpy as np

from rocsafe_dataset.options import DatasetOptions
from rocsafe_scene.ground.terrain import Terrain
from rocsafe_scene.mesh.mesh import Floats, rotation_of
from rocsafe_scene.scene.description import PlaceBlock
from rocsafe_scene.scene.environment import Environment, Piece, SceneObject
from rocsafe_scene.scene.sunlight import sun_direction

# Classes of objects that may be moved.
MOVABLE = frozenset(
    ('person', 'animal', 'car', 'police_car', 'lorry', 'fire_engine', 'ambulance', 'debris',
     'drum', 'evidence')
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrangementOptions:
    """Tuning of the arrangements.

    Attributes
    ----------
    missing_share
        Share of the movable objects that are left out.
    shift_std_m
        Standard deviation of the shift of an object, east and north, metres.
    tries
        Places tried for an object before it stays where it is.
    lying_m
        Objects higher than this above the ground lie on other objects and stay, metres.
    least_sun_up
        Sine of the least elevation of the sun.
    """

    missing_share: float = 0.15
    shift_std_m: float = 6.0
    tries: int = 8
    lying_m: float = 0.5
    least_sun_up: float = 0.15


ARRANGEMENTS = ArrangementOptions()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Arrangement:
    """One variant of a scene.

    Attributes
    ----------
    weather
        Weather.
    time
        Time, which sets the sun.
    objects
        Objects in their places.
    """

    weather: str
    time: datetime
    objects: tuple[SceneObject, ...]


def arrange(number: int, environment: Environment, options: DatasetOptions) -> Arrangement:
    """Return arrangement `number` of a scene, from the seed and the number alone."""
    rng = np.random.default_rng([options.seed, 22, number])
    description = environment.description
    weather = str(rng.choice(options.weathers))
    time = _sunny_time(rng, description.light.time, description.place)
    objects = _moved(rng, environment.objects, environment.terrain)
    return Arrangement(weather=weather, time=time, objects=objects)


def box_of(piece: Piece) -> Floats:
    """Return bounds of a piece, (2, 3): those of the box of its mesh, so rather too large."""
    corners = np.array(np.meshgrid(*piece.mesh.bounds.T)).reshape(3, -1).T
    placed = corners @ piece.rotation.T + piece.offset
    return np.stack([placed.min(axis=0), placed.max(axis=0)])


def bounds_of(thing: SceneObject) -> Floats:
    """Return bounds of an object, (2, 3), rather too large."""
    boxes = np.array([box_of(piece) for piece in thing.pieces])
    return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _sunny_time(rng: np.random.Generator, around: datetime, place: PlaceBlock) -> datetime:
    """Return a time within half a year of `around` at which the sun is high enough."""
    for _ in range(200):
        time = around + timedelta(
            days=int(rng.integers(-180, 181)), minutes=int(rng.integers(0, 1440))
        )
        if (
            sun_direction(time, place.latitude_deg, place.longitude_deg)[2]
            > ARRANGEMENTS.least_sun_up
        ):
            return time
    return around


def _moved(
    rng: np.random.Generator, objects: Sequence[SceneObject], terrain: Terrain
) -> tuple[SceneObject, ...]:
    """Return `objects` with the movable ones shifted and turned, a few of them left out."""
    is_free = [_is_free(thing, terrain) for thing in objects]
    taken = [
        box_of(piece)[:, :2]
        for thing, free in zip(objects, is_free, strict=True)
        for piece in ([] if free else thing.pieces)
    ]
    found = []
    for thing, free in zip(objects, is_free, strict=True):
        if free:
            if rng.uniform() < ARRANGEMENTS.missing_share:
                continue
            thing = _elsewhere(rng, thing, terrain, taken)
            taken.append(bounds_of(thing)[:, :2])
        found.append(thing)
    return tuple(found)


def _is_free(thing: SceneObject, terrain: Terrain) -> bool:
    if thing.label not in MOVABLE or thing.path is not None or len(thing.pieces) != 1:
        return False
    offset = thing.pieces[0].offset
    return abs(offset[2] - float(terrain.height_at(offset[None, :2])[0])) < ARRANGEMENTS.lying_m


def _elsewhere(
    rng: np.random.Generator, thing: SceneObject, terrain: Terrain, taken: Sequence[Floats]
) -> SceneObject:
    """Return `thing` moved to a free place, or unchanged if none is found."""
    (piece,) = thing.pieces
    boxes = np.array(taken).reshape(-1, 2, 2)
    above = piece.offset[2] - terrain.height_at(piece.offset[None, :2])[0]
    for _ in range(ARRANGEMENTS.tries):
        place = piece.offset[:2] + rng.normal(0.0, ARRANGEMENTS.shift_std_m, 2)
        turn = rotation_of(math.degrees(float(rng.uniform(-math.pi, math.pi))))
        if not terrain.inner.covers(place[None])[0]:
            continue
        up = above + terrain.height_at(place[None])[0]
        moved = replace(piece, rotation=turn @ piece.rotation, offset=np.array([*place, up]))
        low, high = box_of(moved)[:, :2]
        if not np.any(np.all((boxes[:, 0] < high) & (boxes[:, 1] > low), axis=1)):
            return replace(thing, pieces=(moved,))
    return thing
