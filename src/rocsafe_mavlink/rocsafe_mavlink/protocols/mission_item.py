# SPDX-License-Identifier: Apache-2.0
"""Mission items as they are sent, and the comparison with an item that was read back."""

import math
import struct
from dataclasses import dataclass, replace

from rocsafe_geo.limits import require_count, require_finite
from rocsafe_mavlink.wire.dialect import Message, addressed

GLOBAL, MISSION_FRAME, GLOBAL_RELATIVE, GLOBAL_INT, RELATIVE_INT = 0, 2, 3, 5, 6
# Two frames have the same meaning: autopilots answer with the older one.
_READ_BACK_FRAMES = {RELATIVE_INT: GLOBAL_RELATIVE, GLOBAL_INT: GLOBAL}
# Commands without a place: autopilots change their frame and coordinates.
PLACELESS = frozenset({20, 178, 206, 112, 115})
# Commands whose coordinates are parameters five and six: their frame has no meaning.
FRAMELESS = frozenset({203, 2000})
PARAMETERS = ('param1', 'param2', 'param3', 'param4')
# Heights are stored in centimetres, parameters in as little as two decimals.
HEIGHT_TOLERANCE_M = 0.02
PARAMETER_TOLERANCE = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionItem:
    """One item.

    Attributes
    ----------
    command
        MAV_CMD.
    frame
        MAV_FRAME of `x_e7`, `y_e7` and `z_m`.
    x_e7, y_e7
        Latitude and longitude in 1e-7 degrees.
    z_m
        Height above home, or altitude above mean sea level, depending on the frame.
    parameters
        The first four parameters.
    """

    command: int
    frame: int = RELATIVE_INT
    x_e7: int = 0
    y_e7: int = 0
    z_m: float = 0.0
    parameters: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        require_count('command', self.command, 1, 65_535)
        require_count('x_e7', self.x_e7, -(2**31), 2**31 - 1)
        require_count('y_e7', self.y_e7, -(2**31), 2**31 - 1)
        require_finite('z_m', self.z_m)
        for name, value in zip(PARAMETERS, self.parameters, strict=True):
            require_finite(name, value)

    def message(self, number: int, target: tuple[int, int], mission_type: int) -> Message:
        """Return the item as number `number` of a mission for `target` (system, component)."""
        return addressed(
            'MISSION_ITEM_INT',
            target,
            seq=number,
            frame=self.frame,
            command=self.command,
            autocontinue=1,
            x=self.x_e7,
            y=self.y_e7,
            z=self.z_m,
            mission_type=mission_type,
            **dict(zip(PARAMETERS, self.parameters, strict=True)),
        )


def item_of(message: Message) -> MissionItem:
    """Return the item of a MISSION_ITEM_INT; parameters that are NaN count as 0."""
    parameters = tuple(_or_zero(message[name]) for name in PARAMETERS)
    return MissionItem(
        command=message['command'],
        frame=message['frame'],
        x_e7=message['x'],
        y_e7=message['y'],
        z_m=_or_zero(message['z']),
        parameters=parameters,  # type: ignore[arg-type]
    )


def difference(sent: MissionItem, back: MissionItem) -> str:
    """Return how `back` differs from what was sent; empty if both mean the same."""
    sent, back = _normal(sent), _normal(back)
    for name in ('command', 'frame', 'x_e7', 'y_e7'):
        if getattr(sent, name) != getattr(back, name):
            return f'{name} is {getattr(back, name)}, sent was {getattr(sent, name)}'
    if abs(sent.z_m - back.z_m) > HEIGHT_TOLERANCE_M:
        return f'z_m is {back.z_m:g}, sent was {sent.z_m:g}'
    pairs = zip(PARAMETERS, sent.parameters, back.parameters, strict=True)
    for name, ours, theirs in pairs:
        if abs(_single(ours) - theirs) > PARAMETER_TOLERANCE * max(1.0, abs(ours)):
            return f'{name} is {theirs:g}, sent was {ours:g}'
    return ''


def _normal(item: MissionItem) -> MissionItem:
    if item.command in PLACELESS:
        return replace(item, frame=MISSION_FRAME, x_e7=0, y_e7=0, z_m=0.0)
    if item.command in FRAMELESS:
        return replace(item, frame=MISSION_FRAME, z_m=0.0)
    return replace(item, frame=_READ_BACK_FRAMES.get(item.frame, item.frame))


def _or_zero(value: float) -> float:
    return value if math.isfinite(value) else 0.0


def _single(value: float) -> float:
    """Return `value` in single precision, as it is sent."""
    return float(struct.unpack('<f', struct.pack('<f', value))[0])
