# SPDX-License-Identifier: Apache-2.0
"""A scene: named things on the ground, and the marks that paint them."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from rocsafe_scene.scenery.marks import Colour, Layer, Mark, Placing


@dataclass(frozen=True, slots=True, kw_only=True)
class Thing:
    """Something that stands on the ground.

    Attributes
    ----------
    name : unique in its scene.
    kind : what it is, e.g. "tank_car".
    placing : of its centre.
    size_m : length, width, height; height 0 if it lies flat.
    colour : red, green, blue, 0 to 255, for viewers of boxes.
    ground : marks that lie flat on the ground below it.
    shadow : marks of its shadow.
    body : marks of the thing itself, seen from above.
    """

    name: str
    kind: str
    placing: Placing
    size_m: tuple[float, float, float]
    colour: Colour = (128, 128, 128)
    ground: tuple[Mark, ...] = ()
    shadow: tuple[Mark, ...] = ()
    body: tuple[Mark, ...] = ()


@dataclass(frozen=True, slots=True)
class Scene:
    """Things in painting order."""

    things: tuple[Thing, ...]
    ground: Layer = field(init=False)
    shadows: Layer = field(init=False)
    bodies: Layer = field(init=False)

    def __post_init__(self) -> None:
        names = [thing.name for thing in self.things]
        twice = {name for name in names if names.count(name) > 1}
        if twice:
            raise ValueError(f'things named {sorted(twice)}: names must be unique')
        for layer in ('ground', 'shadow', 'body'):
            marks = _marks(self.things, layer)
            name = {'ground': 'ground', 'shadow': 'shadows', 'body': 'bodies'}[layer]
            object.__setattr__(self, name, Layer(marks))


def _marks(things: Iterable[Thing], layer: str) -> Iterable[Mark]:
    return (mark for thing in things for mark in getattr(thing, layer))
