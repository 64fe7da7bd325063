# SPDX-License-Identifier: Apache-2.0
"""The methods that move a vehicle. Each answers when the movement has ended."""

import asyncio
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.ned import Vector, swapped, yaw_ned, yaw_of
from rocsafe_airsim.values import vector
from rocsafe_airsim.vehicle import AIRBORNE, HOLDING, LANDED, Vehicle, VehicleNow, World
from rocsafe_geo.angle import wrap_rad

NS_PER_S = 1_000_000_000
POLL_S = 0.02
# AirSim climbs to 3 m.
TAKE_OFF_M = 3.0
# A vehicle that stands as near to its goal is there.
NEAR_M, NEAR_RAD, SLOW_MPS = 0.5, math.radians(2.0), 0.15
# Real ones are known by their receiver.
NEAR_BY_FIX_M = 2.0
FORWARD_ONLY = 1
# Half a turn in one order has no shorter way.
WIDEST_TURN_RAD = 2.0
LONGEST_S = 3600.0


class Mover:
    """Moves vehicles, and waits for the end of each movement.

    Another movement of the same vehicle, or its cancelling, ends the wait: the answer is then
    false.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._tasks: Counter[str] = Counter()

    def cancel(self, vehicle: Vehicle) -> None:
        """Let what is awaited of a vehicle end without success."""
        self._tasks[vehicle.name] += 1

    async def take_off(self, vehicle: Vehicle, timeout_s: float) -> bool:
        """Climb above home, if on the ground."""
        now = vehicle.now()
        if now.state in AIRBORNE:
            return True
        latitude, longitude, _ = self._world.to_geodetic(now.true_enu)
        task = self._begin(vehicle)
        height_m = max(now.true_enu[2] - vehicle.origin.home_enu[2], 0.0) + TAKE_OFF_M
        await vehicle.along([(latitude, longitude, height_m)], 0.0)
        goal = (*now.true_enu[:2], vehicle.origin.home_enu[2] + height_m)
        return await self._until(vehicle, task, _is_at(vehicle, goal), timeout_s)

    async def land(self, vehicle: Vehicle, timeout_s: float) -> bool:
        """Land below, and wait for the touch-down."""
        return await self._down(vehicle, 'land', timeout_s)

    async def go_home(self, vehicle: Vehicle, timeout_s: float) -> bool:
        """Return home and land there, as all vehicles of this suite do."""
        return await self._down(vehicle, 'return_home', timeout_s)

    async def hover(self, vehicle: Vehicle) -> bool:
        """Stop."""
        self.cancel(vehicle)
        await vehicle.plain('hold')
        return True

    async def along(
        self,
        vehicle: Vehicle,
        places_ned: Sequence[Vector],
        speed_mps: float,
        timeout_s: float,
        aim: Mapping[str, Any],
    ) -> bool:
        """Fly along places about the vehicle's origin.

        Parameters
        ----------
        aim
            ``drivetrain`` and ``yaw_mode`` of the call.
        """
        if not places_ned:
            raise AirsimError('the path has no place: must have one at least')
        task = self._begin(vehicle)
        goals = [vehicle.origin.to_enu(place) for place in places_ned]
        await self._face(vehicle, task, goals[0], aim)
        if self._tasks[vehicle.name] != task:
            return False
        home_up_m = vehicle.origin.home_enu[2]
        places = []
        for goal in goals:
            latitude, longitude, _ = self._world.to_geodetic(goal)
            places.append((latitude, longitude, goal[2] - home_up_m))
        await vehicle.along(places, _speed(speed_mps))
        return await self._until(vehicle, task, _is_at(vehicle, goals[-1]), timeout_s)

    async def at_velocity(
        self, vehicle: Vehicle, velocity_ned: Vector, duration_s: float, yaw_mode: Any = None
    ) -> bool:
        """Fly at a velocity for some time."""
        task = self._begin(vehicle)
        seconds = _duration(duration_s)
        rate = -math.radians(_yaw_rate_deg(yaw_mode))
        await vehicle.at_velocity(swapped(velocity_ned), seconds, rate)
        return await self._for(vehicle, task, seconds)

    async def at_height(
        self,
        vehicle: Vehicle,
        velocity: tuple[float, float],
        down_m: float,
        duration_s: float,
        yaw_mode: Any = None,
    ) -> bool:
        """Fly at a horizontal velocity (north, east), and reach a height meanwhile."""
        place = vehicle.origin.to_ned(vehicle.now().true_enu)
        seconds = _duration(duration_s)
        down_mps = (down_m - place[2]) / max(seconds, 1.0)
        return await self.at_velocity(vehicle, (*velocity, down_mps), seconds, yaw_mode)

    async def turn(self, vehicle: Vehicle, yaw_deg: float, timeout_s: float) -> bool:
        """Turn to a yaw, degrees clockwise from north."""
        task = self._begin(vehicle)
        yaw = yaw_ned(math.radians(float(yaw_deg)))
        await vehicle.turn(yaw)
        return await self._until(vehicle, task, _faces(yaw), timeout_s)

    async def spin(self, vehicle: Vehicle, rate_deg_s: float, duration_s: float) -> bool:
        """Turn at a yaw rate, degrees per second clockwise."""
        task = self._begin(vehicle)
        rate, left_s = -math.radians(float(rate_deg_s)), _duration(duration_s)
        piece_s = WIDEST_TURN_RAD / abs(rate) if rate else LONGEST_S
        while left_s > 0.0:
            seconds = min(left_s, piece_s)
            await vehicle.at_velocity((0.0, 0.0, 0.0), seconds, rate)
            if not await self._for(vehicle, task, seconds):
                return False
            left_s -= seconds
        return True

    def _begin(self, vehicle: Vehicle) -> int:
        self.cancel(vehicle)
        return self._tasks[vehicle.name]

    async def _down(self, vehicle: Vehicle, verb: str, timeout_s: float) -> bool:
        task = self._begin(vehicle)
        if vehicle.now().state not in AIRBORNE:
            return True
        await vehicle.plain(verb)
        return await self._until(vehicle, task, lambda now: now.state == LANDED, timeout_s)

    async def _face(
        self, vehicle: Vehicle, task: int, goal: Vector, aim: Mapping[str, Any]
    ) -> None:
        """Turn before a way where the call asks for it."""
        now = vehicle.now()
        yaw = _asked_yaw(now, goal, aim)
        if yaw is None or now.state not in AIRBORNE:
            return
        if abs(wrap_rad(yaw - yaw_of(now.attitude))) > NEAR_RAD:
            await vehicle.turn(yaw)
            await self._until(vehicle, task, _faces(yaw), LONGEST_S)

    async def _for(self, vehicle: Vehicle, task: int, seconds: float) -> bool:
        end_ns = self._world.time_ns() + round(seconds * NS_PER_S)
        return await self._until(
            vehicle, task, lambda _: self._world.time_ns() >= end_ns, math.inf
        )

    async def _until(
        self,
        vehicle: Vehicle,
        task: int,
        is_done: Callable[[VehicleNow], bool],
        timeout_s: float,
    ) -> bool:
        """Wait by the time of the mission; false at its end, or if another order came."""
        limit_s = float(timeout_s)
        end_ns = math.inf
        if math.isfinite(limit_s) and limit_s < 1e9:
            end_ns = self._world.time_ns() + max(limit_s, 0.0) * NS_PER_S
        while self._tasks[vehicle.name] == task:
            if is_done(vehicle.now()):
                return True
            if self._world.time_ns() > end_ns:
                return False
            await asyncio.sleep(POLL_S)
        return False


def vector_of(value: Any) -> Vector:
    """Return the numbers of a Vector3r."""
    return tuple(float(value[key]) for key in vector((0.0, 0.0, 0.0)))  # type: ignore[return-value]


def _is_at(vehicle: Vehicle, goal: Vector) -> Callable[[VehicleNow], bool]:
    near_m = NEAR_M if vehicle.is_simulated else NEAR_BY_FIX_M

    def is_at(now: VehicleNow) -> bool:
        return (
            now.state == HOLDING
            and math.dist(now.true_enu, goal) <= near_m
            and math.hypot(*now.velocity_enu) <= SLOW_MPS
        )

    return is_at


def _faces(yaw_enu_rad: float) -> Callable[[VehicleNow], bool]:
    return lambda now: abs(wrap_rad(yaw_of(now.attitude) - yaw_enu_rad)) <= NEAR_RAD


def _asked_yaw(now: VehicleNow, goal: Vector, aim: Mapping[str, Any]) -> float | None:
    mode = aim.get('yaw_mode') or {}
    offset_deg = 0.0 if mode.get('is_rate', True) else float(mode.get('yaw_or_rate', 0.0))
    if aim.get('drivetrain') == FORWARD_ONLY:
        east, north = goal[0] - now.true_enu[0], goal[1] - now.true_enu[1]
        if math.hypot(east, north) < 1.0:
            return None
        return wrap_rad(math.atan2(north, east) - math.radians(offset_deg))
    return None if mode.get('is_rate', True) else yaw_ned(math.radians(offset_deg))


def _yaw_rate_deg(yaw_mode: Any) -> float:
    mode = yaw_mode or {}
    return float(mode.get('yaw_or_rate', 0.0)) if mode.get('is_rate') else 0.0


def _speed(value: Any) -> float:
    speed = float(value)
    if not (math.isfinite(speed) and speed > 0.0):
        raise AirsimError(f'velocity is {speed:g} m/s: must be positive')
    return speed


def _duration(value: Any) -> float:
    seconds = float(value)
    if not 0.0 <= seconds <= LONGEST_S:
        raise AirsimError(f'duration is {seconds:g} s: must be within 0 and {LONGEST_S:g} s')
    return seconds
