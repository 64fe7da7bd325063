# SPDX-License-Identifier: Apache-2.0
"""A vehicle and the world as the methods need them, whatever carries the orders."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rocsafe_airsim.ned import Origin, Quaternion, Vector

# Numbers of VehicleState.
DISARMED, TAKING_OFF, FLYING, HOLDING, RETURNING, LANDING, LANDED, CRASHED = (
    1,
    3,
    4,
    5,
    6,
    7,
    8,
    10,
)
AIRBORNE = frozenset({TAKING_OFF, FLYING, HOLDING, RETURNING, LANDING})


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleNow:
    """Last state of a vehicle.

    Attributes
    ----------
    stamp_ns
        Mission time of the newest place, nanoseconds.
    state
        Number of its state, as in VehicleState.
    text
        Why it is in this state, for people.
    place_enu, velocity_enu
        As measured, metres and m/s in the mission's frame.
    true_enu
        True place of a simulated vehicle, metres.
    attitude
        Attitude of the body (forward, left, up) in ENU.
    position
        Latitude, longitude (degrees) and altitude (m) as measured.
    std_m
        Horizontal and vertical standard deviation of the place, metres.
    """

    stamp_ns: int
    state: int
    text: str
    place_enu: Vector
    velocity_enu: Vector
    true_enu: Vector
    attitude: Quaternion
    position: Vector
    std_m: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """An image of a camera as it is now; pixels are blue, green, red.

    Attributes
    ----------
    place_enu, attitude
        True pose of the optical frame (right, down, ahead) in the mission's frame.
    fov_deg
        Horizontal field of view.
    depth_m, labels
        Depth along the optical axis and number of the instance of each pixel; None where no
        engine draws the images.
    """

    stamp_ns: int
    pixels: NDArray[np.uint8]
    place_enu: Vector
    attitude: Quaternion
    fov_deg: float
    depth_m: NDArray[np.float32] | None = None
    labels: NDArray[np.uint16] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Turn:
    """How a vehicle turns in flight: at a rate, anticlockwise, or to a yaw if that is given."""

    rate_radps: float = 0.0
    yaw_enu_rad: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Light:
    """Sun and air of the scene.

    Attributes
    ----------
    sun_ns
        Time by which the sun stands now, nanoseconds since 1970; None: as the scenario says.
    sun_speed
        Time of the sun over mission time.
    sun_step_s
        The sun moves whenever so much mission time has passed, seconds.
    fog, wetness
        0 to 1.
    """

    sun_ns: int | None = None
    sun_speed: float = 0.0
    sun_step_s: float = 60.0
    fog: float = 0.0
    wetness: float = 0.0

    def changed(self, **values: Any) -> 'Light':
        """Return it with other values."""
        return replace(self, **values)


class Vehicle(Protocol):
    """A vehicle that is listened to and given orders.

    Every order raises `AirsimError` with the vehicle's own words if it is refused or not answered.
    """

    name: str
    is_simulated: bool
    origin: Origin
    home: Vector
    cameras: Sequence[str]

    @property
    def smells(self) -> bool:
        """Whether it carries a gas sensor."""

    @property
    def is_led(self) -> bool:
        """Whether the lease that was taken is still the one that its orders need."""

    def now(self) -> VehicleNow:
        """Return what was last heard; raises `AirsimError` before anything was."""

    async def take(self) -> None:
        """Take the control lease."""

    async def release(self) -> None:
        """Give the control lease back."""

    async def along(self, places: Sequence[Vector], speed_mps: float) -> None:
        """Fly along places: latitude, longitude in degrees and height above home in metres."""

    async def at_velocity(self, velocity_enu: Vector, duration_s: float, turn: Turn) -> None:
        """Fly at a velocity for some time."""

    async def turn(self, yaw_enu_rad: float) -> None:
        """Turn at its place."""

    async def plain(self, verb: str) -> None:
        """Give one of the orders ``hold``, ``land``, ``return_home``."""

    async def set_home(self, position: Vector) -> None:
        """Stand on the ground elsewhere; home and origin are then there.

        `position` is latitude and longitude in degrees, and altitude in metres.
        """

    async def set_wind(self, east_mps: float, north_mps: float) -> None:
        """Fly in another wind."""

    async def set_light(self, light: Light) -> None:
        """Let its cameras see the scene in another light."""

    async def point(self, camera: str, pitch_rad: float, yaw_rad: float) -> None:
        """Point a camera in a gimbal: above the horizon, and from the nose, anticlockwise."""

    async def set_fov(self, camera: str, fov_deg: float) -> None:
        """Let a camera look with another horizontal field of view, degrees."""

    async def look(self, camera: str, *, with_truth: bool) -> Picture:
        """Return the image of a camera now."""

    def label_table(self, camera: str) -> Sequence[Mapping[str, Any]]:
        """Return number, name, class and colour of each instance."""

    def reading(self, kind: str) -> Mapping[str, Any]:
        """Return the newest reading; raises `AirsimError` without one.

        `kind` is ``radiation``, ``gas``, ``imu``, ``barometer``, ``magnetometer`` or ``range``.
        """


class Drawings(Protocol):
    """Drawings for viewers, in the frame of the mission."""

    def draw(self, lines: Sequence[Sequence[Vector]], rgba: Sequence[float], size_m: float,
             *, kind: str, duration_s: float) -> None:  # fmt: skip
        """Show ``points`` or ``lines`` to viewers, places in the mission's frame."""

    def write(self, texts: Sequence[tuple[str, Vector]], rgba: Sequence[float], size_m: float,
              duration_s: float) -> None:  # fmt: skip
        """Show texts at places in the mission's frame."""

    def trace(self, vehicle: str, rgba: Sequence[float], size_m: float) -> None:
        """Show where a vehicle flies from now on."""

    def clear(self) -> None:
        """Remove what was drawn."""


class World(Protocol):
    """The vehicles and their time."""

    vehicles: Mapping[str, Vehicle]
    drawings: Drawings

    def to_geodetic(self, place_enu: Vector) -> Vector:
        """Return latitude, longitude (degrees) and altitude (m) of a place."""

    def to_enu(self, position: Vector) -> Vector:
        """Return the place of a latitude, longitude and altitude."""

    def time_ns(self) -> int:
        """Return mission time, nanoseconds."""

    def is_paused(self) -> bool:
        """Return whether time stands still by order."""

    async def pause(self, *, is_paused: bool) -> None:
        """Stop or start time."""
