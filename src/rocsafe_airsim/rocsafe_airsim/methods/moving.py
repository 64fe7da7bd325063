# SPDX-License-Identifier: Apache-2.0
"""The methods that move a vehicle. Each answers when the movement has ended."""

import asyncio
import math
from collections import Counter, defaultdict
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.given import number
from rocsafe_airsim.methods.given_motion import (
    LONGEST_S,
    _asked_yaw,
    _duration,
    _speed,
    _turn,
    possible,
)
from rocsafe_airsim.ned import Vector, swapped, yaw_ned, yaw_of
from rocsafe_airsim.vehicle import (
    AIRBORNE,
    CRASHED,
    FLYING,
    HOLDING,
    LANDED,
    LANDING,
    TAKING_OFF,
    Turn,
    Vehicle,
    VehicleNow,
    World,
)
from rocsafe_geo.angle import wrap_rad

NS_PER_S = 1_000_000_000
# In these states a vehicle does what a client has ordered, or is about to.
LED = frozenset({TAKING_OFF, FLYING, HOLDING})
POLL_S = 0.02
# AirSim climbs to 3 m.
TAKE_OFF_M, TAKE_OFF_S = 3.0, 60.0
# A vehicle that stands as near to its goal is there.
NEAR_M, NEAR_RAD, SLOW_MPS = 0.5, math.radians(2.0), 0.15
# Real ones are known by their receiver.
NEAR_BY_FIX_M = 2.0


class Mover:
    """Moves vehicles, and waits for the end of each movement.

    Another movement of the same vehicle, or its cancelling, ends the wait: the answer is then
    false. If the client goes meanwhile, the vehicle holds. A vehicle has one order at a time in
    hand: of those that come meanwhile it gets the newest, so that a script that sends orders in a
    loop is obeyed at the pace of the vehicle.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._tasks: Counter[str] = Counter()
        self._in_hand: defaultdict[str, asyncio.Lock] = defaultdict(asyncio.Lock)
        self._holds: set[asyncio.Task[None]] = set()

    def cancel(self, vehicle: Vehicle) -> None:
        """Let what is awaited of a vehicle end without success."""
        self._tasks[vehicle.name] += 1

    async def take_off(self, vehicle: Vehicle, timeout_s: float) -> bool:
        """Climb above home, if on the ground."""
        with self._led(vehicle) as task:
            return await self._take_off(vehicle, task, timeout_s)

    async def _take_off(self, vehicle: Vehicle, task: int, timeout_s: float) -> bool:
        if vehicle.now().state == LANDING and not await self._until(
            vehicle, task, lambda now: now.state != LANDING, timeout_s
        ):
            return False
        now = vehicle.now()
        if now.state in AIRBORNE:
            return True
        latitude, longitude, _ = self._world.to_geodetic(now.true_enu)
        height_m = max(now.true_enu[2] - vehicle.origin.home_enu[2], 0.0) + TAKE_OFF_M
        place = (latitude, longitude, height_m)
        if not await self._give(vehicle, task, lambda: vehicle.along([place], 0.0)):
            return False
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
        task = self._begin(vehicle)
        return await self._give(vehicle, task, lambda: vehicle.plain('hold'))

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
        with self._led(vehicle) as task:
            return await self._along(vehicle, task, places_ned, speed_mps, timeout_s, aim)

    async def _along(
        self,
        vehicle: Vehicle,
        task: int,
        places_ned: Sequence[Vector],
        speed_mps: float,
        timeout_s: float,
        aim: Mapping[str, Any],
    ) -> bool:
        goals = [vehicle.origin.to_enu(possible(place)) for place in places_ned]
        await self._face(vehicle, task, goals[0], aim)
        home_up_m = vehicle.origin.home_enu[2]
        places = []
        for goal in goals:
            latitude, longitude, _ = self._world.to_geodetic(goal)
            places.append((latitude, longitude, goal[2] - home_up_m))
        speed = _speed(speed_mps)
        if not await self._give(vehicle, task, lambda: vehicle.along(places, speed)):
            return False
        return await self._until(vehicle, task, _is_at(vehicle, goals[-1]), timeout_s)

    async def at_velocity(
        self, vehicle: Vehicle, velocity_ned: Vector, duration_s: float, yaw_mode: Any = None
    ) -> bool:
        """Fly at a velocity for some time; upwards from the ground it takes off first."""
        seconds, turn = _duration(duration_s), _turn(yaw_mode)
        velocity_ned = possible(velocity_ned)
        if velocity_ned[2] < 0.0:
            await self.take_off(vehicle, TAKE_OFF_S)
        return await self._fly_at(vehicle, swapped(velocity_ned), seconds, turn)

    async def _fly_at(
        self, vehicle: Vehicle, velocity_enu: Vector, seconds: float, turn: Turn
    ) -> bool:
        with self._led(vehicle) as task:
            given = self._give(
                vehicle, task, lambda: vehicle.at_velocity(velocity_enu, seconds, turn)
            )
            return await given and await self._for(vehicle, task, seconds)

    async def at_height(
        self,
        vehicle: Vehicle,
        velocity: tuple[float, float],
        down_m: float,
        duration_s: float,
        yaw_mode: Any = None,
    ) -> bool:
        """Fly at a horizontal velocity (north, east), and reach a height meanwhile."""
        seconds, turn = _duration(duration_s), _turn(yaw_mode)
        north_mps, east_mps, down_m = possible((*velocity, down_m))
        if down_m < vehicle.origin.to_ned(vehicle.now().true_enu)[2]:
            await self.take_off(vehicle, TAKE_OFF_S)
        place = vehicle.origin.to_ned(vehicle.now().true_enu)
        down_mps = (down_m - place[2]) / max(seconds, 1.0)
        return await self._fly_at(vehicle, swapped((north_mps, east_mps, down_mps)), seconds, turn)

    async def turn(self, vehicle: Vehicle, yaw_deg: float, timeout_s: float) -> bool:
        """Turn to a yaw, degrees clockwise from north."""
        yaw = yaw_ned(math.radians(number(yaw_deg, 'yaw')))
        with self._led(vehicle) as task:
            given = self._give(vehicle, task, lambda: vehicle.turn(yaw))
            return await given and await self._until(vehicle, task, _faces(yaw), timeout_s)

    async def spin(self, vehicle: Vehicle, rate_deg_s: float, duration_s: float) -> bool:
        """Turn at a yaw rate, degrees per second clockwise."""
        turn = Turn(rate_radps=-math.radians(number(rate_deg_s, 'yaw_rate')))
        return await self._fly_at(vehicle, (0.0, 0.0, 0.0), _duration(duration_s), turn)

    def _begin(self, vehicle: Vehicle) -> int:
        self.cancel(vehicle)
        return self._tasks[vehicle.name]

    async def _give(
        self, vehicle: Vehicle, task: int, order: Callable[[], Awaitable[None]]
    ) -> bool:
        """Give an order when the one before is answered; false if a newer one has come."""
        async with self._in_hand[vehicle.name]:
            if self._tasks[vehicle.name] != task:
                return False
            await order()
            return True

    async def _down(self, vehicle: Vehicle, verb: str, timeout_s: float) -> bool:
        task = self._begin(vehicle)
        state = vehicle.now().state
        if state not in AIRBORNE:
            return True
        # One that lands already is on its way down.
        if state != LANDING and not await self._give(vehicle, task, lambda: vehicle.plain(verb)):
            return False
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
            await self._give(vehicle, task, lambda: vehicle.turn(yaw))
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
        """Wait by the time of the mission; false at its end, or if another order came.

        Also if the flight has ended otherwise: a failsafe landed the vehicle, or it crashed.
        """
        limit_s = number(timeout_s, 'timeout_sec', is_finite=False)
        end_ns = math.inf
        if math.isfinite(limit_s) and limit_s < 1e9:
            end_ns = self._world.time_ns() + max(limit_s, 0.0) * NS_PER_S
        has_flown = False
        while self._tasks[vehicle.name] == task:
            now = vehicle.now()
            if is_done(now):
                return True
            has_flown |= now.state in AIRBORNE
            is_down = now.state == CRASHED or (has_flown and now.state not in AIRBORNE)
            if is_down or self._world.time_ns() > end_ns:
                return False
            await asyncio.sleep(POLL_S)
        return False

    @contextmanager
    def _led(self, vehicle: Vehicle) -> Iterator[int]:
        """Begin a movement that ends when its client goes; gives its number."""
        task = self._begin(vehicle)
        try:
            yield task
        except asyncio.CancelledError:
            self._leave(vehicle, task)
            raise

    def _leave(self, vehicle: Vehicle, task: int) -> None:
        """Let a vehicle hold whose client has gone."""
        if self._tasks[vehicle.name] == task and vehicle.now().state in LED:
            self.cancel(vehicle)
            hold = asyncio.get_running_loop().create_task(_held(vehicle))
            self._holds.add(hold)
            hold.add_done_callback(self._holds.discard)


async def _held(vehicle: Vehicle) -> None:
    with suppress(AirsimError):
        await vehicle.plain('hold')


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
