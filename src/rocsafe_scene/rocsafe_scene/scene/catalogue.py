# SPDX-License-Identifier: Apache-2.0
"""Makers of objects, by the names that scene files use."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from rocsafe_scene.mesh.mesh import Floats, Mesh
from rocsafe_scene.parts import buildings, clutter, people, plants, road_vehicles, wreckage
from rocsafe_scene.parts import rolling_stock as rail

MeshMaker = Callable[..., Mesh]


@dataclass(frozen=True, slots=True, kw_only=True)
class Maker:
    """How objects of a kind are made.

    Attributes
    ----------
    function
        Function that returns the mesh; options are its keyword arguments.
    label
        Class of the objects, unless the scene file gives another.
    material, fill
        Material for rays, and the share of the volume that it fills.
    piece_m
        Length of the pieces of objects made along a line, metres; 0 for objects at one place.
    is_foliage
        Whether polygons are visible from both sides.
    """

    function: MeshMaker
    label: str
    material: str = 'steel'
    fill: float = 0.05
    piece_m: float = 0.0
    is_foliage: bool = False

    @property
    def is_random(self) -> bool:
        """Whether each object has a shape of its own."""
        return 'rng' in inspect.signature(self.function).parameters

    @property
    def options(self) -> tuple[str, ...]:
        """Options that a scene file may set."""
        names = inspect.signature(self.function).parameters
        return tuple(name for name in names if name not in ('rng', 'course'))

    def make(self, rng: np.random.Generator, options: Mapping[str, Any]) -> Mesh:
        """Return a mesh of an object at one place."""
        return self.function(rng, **options) if self.is_random else self.function(**options)

    def make_along(
        self, rng: np.random.Generator, course: Floats, options: Mapping[str, Any]
    ) -> Mesh:
        """Return a mesh along `course` (k, 3)."""
        given = (rng, course) if self.is_random else (course,)
        return self.function(*given, **options)


MAKERS: Mapping[str, Maker] = {
    'locomotive': Maker(function=rail.locomotive, label='locomotive', fill=0.18),
    'tank_car': Maker(function=rail.tank_car, label='tank_car', fill=0.06),
    'flat_car': Maker(function=rail.flat_car, label='flat_car', fill=0.3),
    'box_car': Maker(function=rail.box_car, label='box_car', fill=0.05),
    'flask': Maker(function=rail.flask, label='flask', material='lead', fill=0.35),
    'flask_car': Maker(function=rail.flask_car, label='flat_car', fill=0.3),
    'car': Maker(function=road_vehicles.car, label='car', fill=0.03),
    'police_car': Maker(function=road_vehicles.police_car, label='police_car', fill=0.03),
    'fire_engine': Maker(function=road_vehicles.fire_engine, label='fire_engine', fill=0.06),
    'ambulance': Maker(function=road_vehicles.ambulance, label='ambulance', fill=0.03),
    'lorry': Maker(function=road_vehicles.lorry, label='lorry', fill=0.04),
    'road_tanker': Maker(function=road_vehicles.road_tanker, label='road_tanker', fill=0.05),
    'house': Maker(function=buildings.house, label='house', material='brick', fill=0.2),
    'barn': Maker(function=buildings.barn, label='house', material='concrete', fill=0.05),
    'tent': Maker(function=buildings.tent, label='tent', material='water', fill=0.002),
    'person': Maker(function=people.person, label='person', material='water', fill=1.0),
    'sheep': Maker(function=people.sheep, label='animal', material='water', fill=1.0),
    'tree': Maker(
        function=plants.tree, label='tree', material='wood', fill=0.01, is_foliage=True
    ),
    'shrub': Maker(
        function=plants.shrub, label='shrub', material='wood', fill=0.01, is_foliage=True
    ),
    'hedge': Maker(
        function=plants.hedge, label='hedge', material='wood', fill=0.02, piece_m=10.0,
        is_foliage=True,
    ),
    'drum': Maker(function=clutter.drum, label='drum', material='water', fill=0.9),
    'crate': Maker(function=clutter.crate, label='debris', material='wood', fill=0.3),
    'cone': Maker(function=clutter.cone, label='marker', material='water', fill=0.1),
    'evidence_marker': Maker(
        function=clutter.evidence_marker, label='evidence', material='water', fill=0.1
    ),
    'debris': Maker(function=clutter.debris, label='debris', fill=0.5),
    'tape': Maker(
        function=clutter.tape, label='cordon', material='water', fill=0.05, piece_m=18.0,
        is_foliage=True,
    ),
    'fence': Maker(
        function=clutter.fence, label='fence', material='wood', fill=0.5, piece_m=24.0
    ),
    'rails': Maker(function=clutter.rails, label='rail', fill=1.0, piece_m=20.0),
    'sleepers': Maker(
        function=clutter.sleepers, label='sleeper', material='concrete', fill=1.0, piece_m=20.0
    ),
    'bent_rails': Maker(function=wreckage.bent_rails, label='rail', fill=1.0, piece_m=1e6),
    'torn_sleepers': Maker(
        function=wreckage.torn_sleepers, label='sleeper', material='concrete', fill=1.0,
        piece_m=20.0,
    ),
    'stone_wall': Maker(
        function=wreckage.stone_wall, label='wall', material='concrete', fill=0.8, piece_m=12.0
    ),
    'barrier_pole': Maker(function=clutter.barrier_pole, label='marker', fill=0.2),
}  # fmt: skip


def maker_of(name: str) -> Maker:
    """Return the maker called `name`.

    Raises
    ------
    ValueError
        If there is none.
    """
    if name not in MAKERS:
        raise ValueError(f'make is {name!r}: must be one of {", ".join(MAKERS)}')
    return MAKERS[name]
