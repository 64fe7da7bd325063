# SPDX-License-Identifier: Apache-2.0
"""What the tables of topics and calls say of each: name, type, scope, quality of service."""

from dataclasses import dataclass, replace
from enum import Enum
from typing import TypeVar

from rclpy.qos import QoSProfile

# Topics of a further camera have its name instead of this one.
FIRST_CAMERA = 'camera'


class Scope(Enum):
    """The namespace that a name is relative to: of a vehicle or of the fleet."""

    VEHICLE = 'vehicle'
    FLEET = 'fleet'


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicSpec:
    """One topic.

    Attributes
    ----------
    name
        Name relative to the namespace of `scope`.
    message_type
        Class of its messages.
    qos
        Quality of service offered by its publisher.
    rate
        Its rate, as text for readers.
    note
        Its meaning, as text for readers.
    is_state
        Whether a message makes all earlier ones out of date for whoever acts on it. A publisher
        may keep more of them, for those who record.
    """

    name: str
    message_type: type
    qos: QoSProfile
    scope: Scope
    rate: str
    note: str
    is_state: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class CallSpec:
    """One service or action: `kind` is ``'service'`` or ``'action'``."""

    name: str
    call_type: type
    kind: str
    scope: Scope
    note: str


CameraSpec = TypeVar('CameraSpec', TopicSpec, CallSpec)


def name_of(spec: TopicSpec | CallSpec, vehicle: str = '') -> str:
    """Return the relative name of `spec`, below `vehicle` if one is named.

    Raises
    ------
    ValueError
        If a vehicle is named for a name of fleet scope.
    """
    if not vehicle:
        return spec.name
    if spec.scope is not Scope.VEHICLE:
        raise ValueError(f'{spec.name} belongs to the fleet, not to vehicle {vehicle!r}')
    return f'{vehicle}/{spec.name}'


def of_camera(spec: CameraSpec, camera: str) -> CameraSpec:
    """Return the topic or service of `camera` that corresponds to `spec` of the first camera.

    Raises
    ------
    ValueError
        If `spec` is not of a camera.
    """
    first, _, rest = spec.name.partition('/')
    if first != FIRST_CAMERA or not rest:
        raise ValueError(f'{spec.name} is not of a camera: must begin with {FIRST_CAMERA}/')
    return replace(spec, name=f'{camera}/{rest}')
