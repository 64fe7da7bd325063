# SPDX-License-Identifier: Apache-2.0
"""Methods of wind, weather and time of day."""

import math
from datetime import datetime, timedelta, timezone
from typing import Any

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.access import Access, parameters, served
from rocsafe_airsim.methods.given import number, shown
from rocsafe_airsim.methods.given_motion import vector_of
from rocsafe_airsim.methods.moving import NS_PER_S
from rocsafe_airsim.ned import swapped
from rocsafe_airsim.vehicle import Light

_NAMES = ('Rain', 'Roadwetness', 'Snow', 'RoadSnow', 'MapleLeaf', 'RoadLeaf', 'Dust', 'Fog')
_WETNESS, _FOG = _NAMES.index('Roadwetness'), _NAMES.index('Fog')
_TIME_FORM = '%Y-%m-%d %H:%M:%S'


class WeatherMethods:
    """Wind of all simulated vehicles; fog, wetness and sun of a scene that the engine draws."""

    def __init__(self, at: Access) -> None:
        self._at = at
        self._light = Light()
        self._is_enabled = False

    @served('simSetWind')
    async def _sim_set_wind(self, wind: Any) -> None:
        east_mps, north_mps, up_mps = swapped(vector_of(wind))
        if up_mps:
            raise AirsimError(f'z_val is {-up_mps:g} m/s: must be 0, wind is level here')
        vehicles = self._at.all_simulated()
        for vehicle in vehicles:
            if vehicle.smells:
                raise AirsimError('the gas of this scenario drifts with a wind of its own')
        for vehicle in vehicles:
            await vehicle.set_wind(east_mps, north_mps)

    @served('simEnableWeather')
    async def _sim_enable_weather(self, is_enabled: bool) -> None:
        await self._show(self._light, is_enabled=bool(is_enabled))

    @served('simSetWeatherParameter')
    async def _sim_set_weather_parameter(self, parameter: int, value: float) -> None:
        share, index = number(value, 'value', is_finite=False), int(number(parameter, 'parameter'))
        if not 0 <= index < len(_NAMES):
            raise AirsimError(f'parameter is {index}: must be within 0 and {len(_NAMES) - 1}')
        name = _NAMES[index]
        if not (math.isfinite(share) and 0.0 <= share <= 1.0):
            raise AirsimError(f'{name} is {share:g}: must be within 0 and 1')
        if index == _FOG:
            await self._show(self._light.changed(fog=share), is_enabled=self._is_enabled)
        elif index == _WETNESS:
            await self._show(self._light.changed(wetness=share), is_enabled=self._is_enabled)
        elif share:
            raise AirsimError(f'{name} is not drawn here: there are Roadwetness and Fog')

    @served('simSetTimeOfDay')
    async def _sim_set_time_of_day(self, *call: Any) -> None:
        is_enabled, start, is_summer_time, speed, step_s, moves = parameters(call, 6)[:6]
        sun_ns = None
        if is_enabled:
            sun_ns = self._at.world.time_ns() if not start else _ns_of(start, is_summer_time)
        light = self._light.changed(
            sun_ns=sun_ns,
            sun_speed=number(speed, 'celestial_clock_speed') if moves else 0.0,
            sun_step_s=max(1.0, number(step_s, 'update_interval_secs')),
        )
        await self._show(light, is_enabled=self._is_enabled)

    async def _show(self, light: Light, *, is_enabled: bool) -> None:
        shown = light if is_enabled else light.changed(fog=0.0, wetness=0.0)
        for vehicle in self._at.all_simulated():
            await vehicle.set_light(shown)
        # An order that a vehicle refused is not kept.
        self._light, self._is_enabled = light, is_enabled


def _ns_of(text: Any, is_summer_time: Any) -> int:
    """Return nanoseconds since 1970 of a text in UTC, or an hour ahead of it."""
    try:
        time = datetime.strptime(str(text), _TIME_FORM).replace(tzinfo=timezone.utc)
    except ValueError as error:
        raise AirsimError(
            f'start_datetime is {shown(text)}: must be as 2025-06-01 10:00:00'
        ) from error
    time -= timedelta(hours=1 if is_summer_time else 0)
    return round(time.timestamp()) * NS_PER_S
