# SPDX-License-Identifier: Apache-2.0
"""Methods of the connection, of control and of movements."""

import asyncio
import json
import math
from typing import Any

from rocsafe_airsim import values
from rocsafe_airsim.methods.access import Access, at_least, parameters, served
from rocsafe_airsim.methods.given import number, sequence
from rocsafe_airsim.methods.given_motion import LONGEST_S, possible, vector_of
from rocsafe_airsim.ned import yaw_of
from rocsafe_airsim.vehicle import AIRBORNE, Vehicle

# Versions that clients of AirSim 1.8 and Cosys-AirSim 3 accept.
SERVER_VERSION, OLDEST_CLIENT = 4, 1


class ControlMethods:
    """Connection, control and movements."""

    def __init__(self, at: Access) -> None:
        self._at = at

    @served('ping')
    async def _ping(self) -> bool:
        return True

    @served('getServerVersion')
    async def _get_server_version(self) -> int:
        return SERVER_VERSION

    @served('getMinRequiredClientVersion')
    async def _get_min_required_client_version(self) -> int:
        return OLDEST_CLIENT

    @served('enableApiControl')
    async def _enable_api_control(self, is_enabled: bool, name: str = '') -> None:
        vehicle = self._at.vehicle(name)
        if is_enabled:
            await vehicle.take()
            self._at.controlled.add(vehicle.name)
        elif vehicle.name in self._at.controlled:
            self._at.mover.cancel(vehicle)
            await vehicle.release()
            self._at.controlled.discard(vehicle.name)

    @served('isApiControlEnabled')
    async def _is_api_control_enabled(self, name: str = '') -> bool:
        vehicle = self._at.vehicle(name)
        # Somebody else may have taken the lease over.
        return vehicle.name in self._at.controlled and vehicle.is_led

    @served('armDisarm')
    async def _arm_disarm(self, arm: bool, name: str = '') -> bool:
        vehicle = self._at.vehicle(name)
        # Nothing is moved, so no control is needed: vehicles of this suite arm for a flight and
        # disarm after the landing by themselves.
        return arm or vehicle.now().state not in AIRBORNE

    @served('reset')
    async def _reset(self) -> None:
        """Call all simulated vehicles home; nothing is teleported. Answers when they stand."""
        led = [self._at.vehicle(name) for name in sorted(self._at.controlled)]
        self._at.world.drawings.clear()
        await asyncio.gather(*map(self._bring_home, led))

    async def _bring_home(self, vehicle: Vehicle) -> None:
        if vehicle.is_simulated:
            await self._at.mover.go_home(vehicle, LONGEST_S)
        if vehicle.name in self._at.controlled:
            self._at.controlled.discard(vehicle.name)
            await vehicle.release()

    @served('listVehicles')
    async def _list_vehicles(self) -> list[str]:
        return list(self._at.world.vehicles)

    @served('getSettingsString')
    async def _get_settings_string(self) -> str:
        vehicles = {name: {'VehicleType': 'SimpleFlight'} for name in self._at.world.vehicles}
        return json.dumps({'SettingsVersion': 2.0, 'SimMode': 'Multirotor', 'Vehicles': vehicles})

    @served('getHomeGeoPoint')
    async def _get_home_geo_point(self, name: str = '') -> values.Plain:
        return values.geo_point(self._at.vehicle(name).home)

    @served('takeoff')
    async def _takeoff(self, timeout_s: float = 20.0, name: str = '') -> bool:
        vehicle = self._at.led(name)
        return await self._at.mover.take_off(vehicle, at_least(timeout_s, 20.0))

    @served('land')
    async def _land(self, timeout_s: float = 60.0, name: str = '') -> bool:
        # AirSim's default of a minute is less than a landing from the height of a survey.
        return await self._at.mover.land(self._at.led(name), at_least(timeout_s, 600.0))

    @served('goHome')
    async def _go_home(self, timeout_s: float = 3e38, name: str = '') -> bool:
        return await self._at.mover.go_home(self._at.led(name), timeout_s)

    @served('hover')
    async def _hover(self, name: str = '') -> bool:
        return await self._at.mover.hover(self._at.led(name))

    @served('cancelLastTask')
    async def _cancel_last_task(self, name: str = '') -> None:
        vehicle = self._at.led(name)
        if vehicle.now().state in AIRBORNE:
            await self._at.mover.hover(vehicle)

    @served('moveToPosition')
    async def _move_to_position(self, *call: Any) -> bool:
        x, y, z, velocity, timeout_s, drivetrain, yaw_mode, *_ = parameters(call, 8)
        vehicle = self._at.led(call[-1])
        aim = {'drivetrain': drivetrain, 'yaw_mode': yaw_mode}
        return await self._at.mover.along(vehicle, [(x, y, z)], velocity, timeout_s, aim)

    @served('moveOnPath')
    async def _move_on_path(self, *call: Any) -> bool:
        path, velocity, timeout_s, drivetrain, yaw_mode, *_ = parameters(call, 6)
        aim = {'drivetrain': drivetrain, 'yaw_mode': yaw_mode}
        places = [vector_of(each) for each in sequence(path, 'path')]
        return await self._at.mover.along(self._at.led(call[-1]), places, velocity, timeout_s, aim)

    @served('moveToZ')
    async def _move_to_z(self, *call: Any) -> bool:
        z, velocity, timeout_s, yaw_mode, *_ = parameters(call, 5)
        vehicle = self._at.led(call[-1])
        x, y, _down = vehicle.origin.to_ned(vehicle.now().true_enu)
        aim = {'yaw_mode': yaw_mode}
        return await self._at.mover.along(vehicle, [(x, y, z)], velocity, timeout_s, aim)

    @served('moveToGPS')
    async def _move_to_gps(self, *call: Any) -> bool:
        latitude, longitude, altitude, velocity, timeout_s, drivetrain, yaw_mode, *_ = parameters(
            call, 8
        )
        vehicle = self._at.led(call[-1])
        north_deg, east_deg = number(latitude, 'latitude'), number(longitude, 'longitude')
        place = self._at.world.to_enu((north_deg, east_deg, number(altitude, 'altitude')))
        aim = {'drivetrain': drivetrain, 'yaw_mode': yaw_mode}
        goal = vehicle.origin.to_ned(place)
        return await self._at.mover.along(vehicle, [goal], velocity, timeout_s, aim)

    @served('moveByVelocity')
    async def _move_by_velocity(self, *call: Any) -> bool:
        vx, vy, vz, duration_s, _drive, yaw_mode, *_ = parameters(call, 7)
        velocity = possible((vx, vy, vz))
        return await self._at.mover.at_velocity(
            self._at.led(call[-1]), velocity, duration_s, yaw_mode
        )

    @served('moveByVelocityZ')
    async def _move_by_velocity_z(self, *call: Any) -> bool:
        vx, vy, z, duration_s, _drive, yaw_mode, *_ = parameters(call, 7)
        north_mps, east_mps, down_m = possible((vx, vy, z))
        return await self._at.mover.at_height(
            self._at.led(call[-1]), (north_mps, east_mps), down_m, duration_s, yaw_mode
        )

    @served('moveByVelocityBodyFrame')
    async def _move_by_velocity_body_frame(self, *call: Any) -> bool:
        vx, vy, vz, duration_s, _drive, yaw_mode, *_ = parameters(call, 7)
        vehicle = self._at.led(call[-1])
        ahead_mps, right_mps, down_mps = possible((vx, vy, vz))
        velocity = (*_turned(vehicle, ahead_mps, right_mps), down_mps)
        return await self._at.mover.at_velocity(vehicle, velocity, duration_s, yaw_mode)

    @served('moveByVelocityZBodyFrame')
    async def _move_by_velocity_z_body_frame(self, *call: Any) -> bool:
        vx, vy, z, duration_s, _drive, yaw_mode, *_ = parameters(call, 7)
        vehicle = self._at.led(call[-1])
        ahead_mps, right_mps, down_m = possible((vx, vy, z))
        level = _turned(vehicle, ahead_mps, right_mps)
        return await self._at.mover.at_height(vehicle, level, down_m, duration_s, yaw_mode)

    @served('rotateToYaw')
    async def _rotate_to_yaw(
        self, yaw_deg: float, timeout_s: float = 3e38, _margin: float = 5.0, name: str = ''
    ) -> bool:
        return await self._at.mover.turn(self._at.led(name), yaw_deg, timeout_s)

    @served('rotateByYawRate')
    async def _rotate_by_yaw_rate(
        self, rate_deg_s: float, duration_s: float, name: str = ''
    ) -> bool:
        return await self._at.mover.spin(self._at.led(name), rate_deg_s, duration_s)


def _turned(vehicle: Vehicle, ahead: float, right: float) -> tuple[float, float]:
    """Return north and east of a velocity in the frame of the body."""
    yaw = math.pi / 2.0 - yaw_of(vehicle.now().attitude)
    north = ahead * math.cos(yaw) - right * math.sin(yaw)
    east = ahead * math.sin(yaw) + right * math.cos(yaw)
    return north, east
