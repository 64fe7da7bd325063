# SPDX-License-Identifier: Apache-2.0
"""What all methods share: vehicles by name, who leads them, cameras, instances."""

import re
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any, TypeVar

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.given import number, sequence, shown, text
from rocsafe_airsim.methods.moving import Mover
from rocsafe_airsim.ned import Vector
from rocsafe_airsim.vehicle import Vehicle, World

Method = Callable[..., Awaitable[Any]]
MethodT = TypeVar('MethodT', bound=Method)
# The cameras that every vehicle of AirSim has, by number and by name; all are the first here.
FIRST_CAMERA_NAMES = frozenset({
    '', '0', '1', '2', '3', '4',
    'front_center', 'front_right', 'front_left', 'bottom_center', 'back_center',
})  # fmt: skip
# AirSim's own examples name their vehicles so.
_NUMBERED = re.compile(r'(?:[Dd]rone|[Vv]ehicle|UAV)_?(\d+)$')
_ESCAPED = re.compile(r'\\.', re.DOTALL)
_REPEATED_GROUP = re.compile(r'\)[*+{]')
MOST_REPEATS = 3
_WHITE = (1.0, 1.0, 1.0, 1.0)
# Messages hold seconds in 32 bits.
LONGEST_SHOWN_S = 1e9
# Height of letters of AirSim's scale 1; longer texts are cut.
_LETTER_M, LONGEST_TEXT = 0.1, 200


def served(name: str) -> Callable[[MethodT], MethodT]:
    """Mark a function as the method `name` of AirSim."""

    def mark(function: MethodT) -> MethodT:
        function.airsim_name = name  # type: ignore[attr-defined]
        return function

    return mark


def methods_of(part: object) -> Mapping[str, Method]:
    """Return the methods that an object serves, by name."""
    found = {}
    for attribute in dir(part):
        function = getattr(part, attribute)
        if name := getattr(function, 'airsim_name', ''):
            found[name] = function
    return found


class Access:
    """Finds what a call names, and refuses what its client may not do.

    Parameters
    ----------
    world
        The vehicles and their time.
    tell
        Takes a line for people.

    Attributes
    ----------
    controlled
        Names of the vehicles for which a client has called enableApiControl.
    ids
        Segmentation ids by number of the instance.
    """

    def __init__(self, world: World, tell: Callable[[str], None]) -> None:
        self.world, self.tell = world, tell
        self.mover = Mover(world)
        self.controlled: set[str] = set()
        self.ids: dict[int, int] = {}

    def vehicle(self, name: Any) -> Vehicle:
        """Return the vehicle of a name; the first if it is empty."""
        vehicles = self.world.vehicles
        if not vehicles:
            raise AirsimError('no vehicle is heard')
        if not name:
            return next(iter(vehicles.values()))
        if text(name, 'vehicle_name') in vehicles:
            return vehicles[name]
        numbered = _NUMBERED.match(name)
        if numbered and 1 <= int(numbered[1]) <= len(vehicles):
            return list(vehicles.values())[int(numbered[1]) - 1]
        raise AirsimError(f'vehicle {shown(name)}: there are {", ".join(vehicles)}')

    def simulated(self, name: Any) -> Vehicle:
        """Return a simulated vehicle."""
        vehicle = self.vehicle(name)
        if not vehicle.is_simulated:
            raise AirsimError(f'{vehicle.name} is a real vehicle: sim methods are refused')
        return vehicle

    def all_simulated(self) -> list[Vehicle]:
        """Return all simulated vehicles, of which there must be one."""
        found = [each for each in self.world.vehicles.values() if each.is_simulated]
        if not found:
            raise AirsimError('there are only real vehicles: sim methods are refused')
        return found

    def led(self, name: Any) -> Vehicle:
        """Return a vehicle that clients lead."""
        vehicle = self.vehicle(name)
        if vehicle.name not in self.controlled:
            raise AirsimError(f'{vehicle.name}: call enableApiControl first')
        return vehicle

    def camera(self, vehicle: Vehicle, name: Any) -> str:
        """Return the name of a camera of a vehicle."""
        if name in vehicle.cameras:
            return str(name)
        if str(name) in FIRST_CAMERA_NAMES and vehicle.cameras:
            return vehicle.cameras[0]
        known = ', '.join(vehicle.cameras) or 'none'
        raise AirsimError(f'camera {shown(name)} of {vehicle.name}: has {known}')

    def instances(self) -> Sequence[Mapping[str, Any]]:
        """Return number, name, class and colour of each thing of the scene."""
        for vehicle in self.world.vehicles.values():
            for camera in vehicle.cameras:
                if table := vehicle.label_table(camera):
                    return table
        return ()

    def instance(self, name: Any) -> Mapping[str, Any] | None:
        """Return the thing of a name, whatever its case; None if there is none."""
        wanted = text(name, 'object_name').lower()
        same = (row for row in self.instances() if str(row['name']).lower() == wanted)
        return next(same, None)

    def draw(
        self,
        lines_ned: Sequence[Sequence[Vector]],
        rgba: Any,
        size: Any,
        kind: str,
        lasting: tuple[Any, Any],
    ) -> None:
        """Show lines or points; `lasting` is their duration in seconds, and whether for ever."""
        origin = self.vehicle('').origin
        lines = [[origin.to_enu(place) for place in line] for line in lines_ned]
        duration_s = 0.0 if lasting[1] else shown_s(lasting[0])
        colour, size_m = pen(rgba, size)
        self.world.drawings.draw(lines, colour, size_m, kind=kind, duration_s=duration_s)

    def write(
        self,
        texts: Sequence[Any],
        places_ned: Sequence[Vector],
        rgba: Any,
        scale: Any,
        duration_s: Any,
    ) -> None:
        """Show texts, each at its place."""
        origin = self.vehicle('').origin
        placed = [
            (str(text)[:LONGEST_TEXT], origin.to_enu(place))
            for text, place in zip(texts, places_ned, strict=True)
        ]
        size_m = max(number(scale, 'scale') * _LETTER_M, 0.05)
        self.world.drawings.write(placed, pen(rgba, 0.0)[0], size_m, shown_s(duration_s))


def shown_s(duration_s: Any) -> float:
    """Return how long a drawing is shown, seconds; 0 is for ever."""
    return min(max(number(duration_s, 'duration'), 0.0), LONGEST_SHOWN_S)


def pen(rgba: Any, size: Any) -> tuple[tuple[float, ...], float]:
    """Return colour and width, metres, of a drawing."""
    # AirSim's sizes are pixels or centimetres of its engine.
    colour = tuple(number(each, 'color_rgba') for each in sequence(rgba or _WHITE, 'color_rgba'))
    if len(colour) != len(_WHITE):
        raise AirsimError(f'color_rgba has {len(colour)} numbers: must have {len(_WHITE)}')
    return colour, max(number(size, 'size') / 100.0, 0.05)


def parameters(call: tuple[Any, ...], least: int) -> tuple[Any, ...]:
    """Return the parameters of a call, of which there must be `least`."""
    if len(call) < least:
        raise AirsimError(f'{len(call)} parameters: must be {least} or more')
    return call


def at_least(timeout_s: Any, default_s: float) -> float:
    """Return a time limit that a vehicle of this suite can keep."""
    return max(number(timeout_s, 'timeout_sec', is_finite=False), default_s)


def matches(pattern: Any, row: Mapping[str, Any]) -> bool:
    """Return whether the name of an instance matches a regular expression.

    Raises
    ------
    AirsimError
        If it is none, or one for which a search could take hours, in which nobody else is served.
    """
    plain = _ESCAPED.sub('', text(pattern, 'the name'))
    repeats = sum(map(plain.count, '*+{'))
    if repeats > MOST_REPEATS or _REPEATED_GROUP.search(plain):
        raise AirsimError(
            f'{pattern[:80]!r}: must have {MOST_REPEATS} repeats at most, and no repeated group'
        )
    try:
        return re.fullmatch(pattern, str(row['name']), re.IGNORECASE) is not None
    except re.error as error:
        raise AirsimError(f'{pattern!r} is no regular expression: {error}') from error
