# SPDX-License-Identifier: Apache-2.0
"""The sensors of one vehicle: readings from its way through the air."""

import math
import zlib
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.agents.agent_table import Agent
from rocsafe_dispersion.air_field.air_field import AirField, GeoPlace
from rocsafe_dispersion.air_field.air_file import AirFile
from rocsafe_dispersion.detection.gas_sensor import GasSensor, Intake
from rocsafe_dispersion.detection.particle_counter import (
    CountingWindows,
    ParticleCount,
    ParticleCounter,
)
from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_dispersion.detection.sensor_windows import GasMeasurement, GasSample, WindowSensor
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.time_units import NS_PER_S

MG_PER_G = 1000.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """A moment of a flight: where the vehicle is, and where it believes to be (NaN: unknown)."""

    time_ns: int
    place: GeoPlace
    believed: GeoPlace


@dataclass(frozen=True, slots=True, kw_only=True)
class WindMeasurement:
    """Mean wind over a window, towards east, north and up, and the scatter of its direction."""

    towards_mps: tuple[float, float, float]
    std_mps: float
    sigma_theta_rad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class WindowEnd:
    """What particle counter and anemometer read in the window that ends at `time_ns`."""

    time_ns: int
    believed: GeoPlace
    count: ParticleCount | None
    wind: WindMeasurement | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Readings:
    """All readings that a moment completes."""

    gases: tuple[tuple[GasSensor, GasMeasurement], ...]
    window: WindowEnd | None


class VehicleSensors:
    """The sensors of one vehicle; readings depend on seed, vehicle, window and way alone."""

    def __init__(
        self, vehicle: str, settings: AirFile, air: AirField, window_s: float, seed: int
    ) -> None:
        intake = Intake(dilution=settings.dilution, delay_s=settings.intake_delay_s)
        self._air, self._settings, self._seed = air, settings, seed
        self._window_ns = round(window_s * NS_PER_S)
        self._name = zlib.crc32(f'{vehicle}/anemometer'.encode())
        self._gas = [
            (kind, WindowSensor(kind, own, vehicle, window_s, seed))
            for kind in (GAS_SENSORS[name] for name in settings.gas_sensors)
            for own in (Intake() if kind.is_open_path else intake,)
        ]
        self._counter = CountingWindows(ParticleCounter(), vehicle, window_s, seed)
        self._window: int | None = None
        self._is_whole = False
        self._moments: list[tuple[GeoPlace, float, FloatArray]] = []

    def add(self, moment: Moment, time_s: float) -> Readings:
        """Take a moment, later than all before, `time_s` after the start of the mission."""
        # What is beside the vehicle, and what is below it.
        kinds = {sensor.is_open_path for sensor, _ in self._gas}
        beside, below = (
            look(time_s, moment.place) if is_path in kinds else []
            for is_path, look in ((False, self._air.gases_g_m3), (True, self._air.columns_g_m2))
        )
        found = []
        for sensor, windows in self._gas:
            gases = below if sensor.is_open_path else beside
            value = sum(sensor.response(agent) * _amount(sensor, agent, c) for agent, c in gases)
            sample = GasSample(time_ns=moment.time_ns, value=value, believed=moment.believed)
            reading = windows.add(sample)
            if reading is not None:
                found.append((sensor, reading))
        return Readings(gases=tuple(found), window=self._windowed(moment, time_s))

    def _windowed(self, moment: Moment, time_s: float) -> WindowEnd | None:
        """Add the moment to its window; return the last one if this is the first after it."""
        if not (self._settings.particle_counter or self._settings.anemometer):
            return None
        # The end of a window belongs to it, its beginning does not.
        index = (moment.time_ns - 1) // self._window_ns
        ended = None
        if index != self._window:
            ended = self._ended()
            self._is_whole = self._window is not None and index == self._window + 1
            self._window, self._moments = index, []
        particles = (
            self._air.particles_per_l(time_s, moment.place) * self._settings.dilution
            if self._settings.particle_counter
            else 0.0
        )
        wind = self._air.wind_mps(time_s, moment.place)
        self._moments.append((moment.believed, particles, wind))
        return ended

    def _ended(self) -> WindowEnd | None:
        if self._window is None or not self._is_whole or not self._moments:
            return None
        believed, particles, winds = zip(*self._moments, strict=True)
        places = np.array(believed)
        known = places[np.isfinite(places).all(axis=1)]
        latitude, longitude, altitude = (
            known.mean(axis=0).tolist() if len(known) else [math.nan] * 3
        )
        return WindowEnd(
            time_ns=(self._window + 1) * self._window_ns,
            believed=(latitude, longitude, altitude),
            count=(
                self._counter.count(self._window, math.fsum(particles) / len(particles))
                if self._settings.particle_counter
                else None
            ),
            wind=self._wind(np.array(winds)) if self._settings.anemometer else None,
        )

    def _wind(self, winds: FloatArray) -> WindMeasurement:
        generator = np.random.default_rng([self._seed, self._name, self._window or 0])
        std = self._settings.anemometer_std_mps
        east, north, up = (winds.mean(axis=0) + std * generator.standard_normal(3)).tolist()
        angles = np.unwrap(np.arctan2(winds[:, 1], winds[:, 0]))
        return WindMeasurement(
            towards_mps=(east, north, up), std_mps=std, sigma_theta_rad=float(angles.std())
        )


def _amount(sensor: GasSensor, agent: Agent, concentration_g_m3: float) -> float:
    """Return a concentration in the unit of a sensor."""
    if sensor.unit == 'mg_m3':
        return MG_PER_G * concentration_g_m3
    return agent.ppm(concentration_g_m3)
