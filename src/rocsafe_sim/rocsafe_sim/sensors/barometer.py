# SPDX-License-Identifier: Apache-2.0
"""A barometer in the ICAO standard atmosphere.

The altitude above the ellipsoid counts as that above the sea, and the wind of flight and rotors
does not change the pressure.
"""

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.clock.cadence import period_ns
from rocsafe_sim.sensors.body_motion import StateAt
from rocsafe_sim.sensors.errors_over_time import Draws, ErrorModel
from rocsafe_sim.sensors.readings import PressureReading
from rocsafe_sim.sensors.sensor_settings import BarometerSettings
from rocsafe_sim.sensors.streams import Stream

DRIFT_PERIOD_NS = 3600 * NS_PER_S
# ICAO Doc 7488: radius for geopotential heights, m; temperature at sea level, K; its fall with
# height, K/m; standard gravity, m/s^2; gas constant of dry air, J/(kg K).
_RADIUS_M, _SEA_LEVEL_K, _LAPSE, _GRAVITY, _GAS = 6_356_766.0, 288.15, 0.0065, 9.80665, 287.05287


class Barometer:
    """A sensor of the pressure of the air.

    Parameters
    ----------
    settings
        Rate, errors and pressure at sea level.
    draws
        Random values of the vehicle.
    frame
        Local frame of the mission.
    """

    def __init__(self, settings: BarometerSettings, draws: Draws, frame: LocalFrame) -> None:
        self.period_ns = period_ns(settings.rate_hz)
        self._sea_level_pa = settings.sea_level_pressure_pa
        self._draws, self._frame = draws, frame
        self._errors = ErrorModel(
            white_std=settings.noise_std_pa,
            drift_std=settings.drift_std_pa,
            drift_period_ns=DRIFT_PERIOD_NS,
            streams=(Stream.BAROMETER_WHITE, Stream.BAROMETER_DRIFT),
        )

    def read(self, time_ns: int, state_at: StateAt) -> PressureReading:
        """Return the sample at a time."""
        altitude_m = self._frame.position_of(state_at(time_ns).position_enu).altitude_m
        true_pa = pressure_pa(altitude_m, self._sea_level_pa)
        error_pa = self._errors.at(self._draws, time_ns)[0]
        return PressureReading(
            time_ns=time_ns, pressure_pa=true_pa + error_pa, variance=self._errors.variance
        )


def pressure_pa(altitude_m: float, sea_level_pa: float) -> float:
    """Return the pressure at a height above the sea, up to 11 km (ICAO Doc 7488)."""
    height_m = _RADIUS_M * altitude_m / (_RADIUS_M + altitude_m)
    warmth = 1.0 - _LAPSE * height_m / _SEA_LEVEL_K
    return float(sea_level_pa * warmth ** (_GRAVITY / (_GAS * _LAPSE)))
