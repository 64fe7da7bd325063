# SPDX-License-Identifier: Apache-2.0
"""Readings of gas and wind of a running flight, each once, and the survey that they make."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.agents.agent_table import PARTICLES, Agent, agent
from rocsafe_dispersion.detection.gas_sensor import OPEN_PATH
from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_dispersion.estimation import amount
from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S

# Readings are averaged to at most so many blocks, each at least so long: a fit takes seconds.
MOST_BLOCKS = 120
LEAST_BLOCK_S = 4.0
# Points of the way flown in a block.
POINTS = 5
# Heights of a path straight down to the ground, and their weights, on the interval -1 to 1.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(6)
# The wind of a block is the mean of this time before its end: a plume arrives with its past.
WIND_S = 20.0
# The wind that plumes and zones are told for, a mean of ten minutes, is that of the last so long.
RECENT_S = 600.0
# Rotors blow a sample down, never below this height above the ground, metres.
LEAST_HEIGHT_M = 0.5
# Unit of counts of particles.
PER_M3 = amount.PARTICLES.concentration_key


class NoSurveyError(ValueError):
    """The readings make no survey yet."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GasFlightReading:
    """One reading of a gas sensor or of a particle counter.

    Fields as in GasReading, its place NaN if unknown. Particles are in ``per_m3``.
    """

    vehicle: str
    time_ns: int
    sensor: str
    unit: str
    calibration_gas: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    raw: float
    corrected: float
    std: float
    limit: float
    is_saturated: bool

    @property
    def is_usable(self) -> bool:
        """Whether its place is known, its unit is one that is located, and it is finite."""
        values = (self.latitude_deg, self.longitude_deg, self.altitude_m, self.corrected, self.std)
        return self.unit in ('ppm', PER_M3, OPEN_PATH) and all(map(math.isfinite, values))


@dataclass(frozen=True, slots=True, kw_only=True)
class WindFlightReading:
    """Mean wind over a window, where the air goes to, at an altitude."""

    vehicle: str
    time_ns: int
    altitude_m: float
    towards_east_mps: float
    towards_north_mps: float

    @property
    def is_usable(self) -> bool:
        """Whether all of it is known."""
        values = (self.altitude_m, self.towards_east_mps, self.towards_north_mps)
        return all(map(math.isfinite, values))


@dataclass(frozen=True, slots=True, kw_only=True)
class Sampling:
    """How air comes to the sensors, and what they are told of the agent.

    Attributes
    ----------
    dilution
        Share of the concentration that arrives below the rotors.
    delay_s
        Time from the air beside the vehicle to the sensor, seconds.
    agent
        What is released, a chemical or particles; empty: what the sensor is made for.
    """

    dilution: float = 1.0
    delay_s: float = 0.0
    agent: str = ''

    def __post_init__(self) -> None:
        is_chemical = self.agent not in ('', PARTICLES.name)
        if is_chemical and agent(self.agent).molar_mass_g_mol is None:
            raise ValueError(f'agent {self.agent!r} needs a known molar mass')


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FlightSurvey:
    """The survey of a flight, with the sensor used, the agent it stands for, and mean values."""

    survey: GasSurvey
    sensor: str
    agent: Agent
    wind_towards_mps: tuple[float, float]
    anemometer_m: float
    flight_height_m: float


class GasLog:
    """Collects readings above level ground at the altitude of the frame's origin."""

    def __init__(self, frame: LocalFrame, sampling: Sampling) -> None:
        self.frame, self._sampling = frame, sampling
        self._gases: dict[str, dict[tuple[str, int], GasFlightReading]] = {}
        self._winds: dict[tuple[str, int], WindFlightReading] = {}
        self.newest_ns = self.newest_wind_ns = 0
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add_gas(self, reading: GasFlightReading) -> bool:
        """Add a reading and return whether it is usable and new."""
        own = self._gases.setdefault(reading.sensor, {})
        key = (reading.vehicle, reading.time_ns)
        if key in own or not reading.is_usable:
            return False
        own[key] = reading
        self._count += 1
        self.newest_ns = max(self.newest_ns, reading.time_ns)
        return True

    def add_wind(self, reading: WindFlightReading) -> bool:
        """Add a reading of the wind and return whether it is usable and new."""
        key = (reading.vehicle, reading.time_ns)
        if key in self._winds or not reading.is_usable:
            return False
        self._winds[key] = reading
        self.newest_wind_ns = max(self.newest_wind_ns, reading.time_ns)
        return True

    def readings(self) -> Iterator[GasFlightReading]:
        """Yield all readings of gas, of one sensor after the other."""
        for own in self._gases.values():
            yield from own.values()

    def highest(self, sensor: str) -> GasFlightReading:
        """Return the highest reading of a kind of sensor, the earliest of equal ones."""
        own = self._gases[sensor].values()
        return max(own, key=lambda one: (one.corrected, -one.time_ns))

    def survey(self) -> FlightSurvey:
        """Return the survey of all readings so far.

        Raises
        ------
        NoSurveyError
            If there is no reading of gas or of the wind, or no sensor that could see the agent.
        """
        if not self._winds:
            raise NoSurveyError('no reading of the wind')
        sensor = self._best_sensor()
        readings = self._gases[sensor]
        known, factor = self._scale(next(iter(readings.values())))
        times, towards = _sorted_winds(self._winds.values())
        ground = self.frame.origin.altitude_m
        unit = next(iter(readings.values())).unit
        # Only what is drawn in comes later: counters and light are in the air that they read.
        delay_s = self._sampling.delay_s if unit == 'ppm' else 0.0
        blocks = _blocks(readings, self.frame, delay_s)
        values: FloatArray = np.array([block.mean for block in blocks])
        noise = max(_noise([block.mean for block in blocks]), 1e-12)
        std: FloatArray = np.maximum(noise, [block.std for block in blocks])
        places: FloatArray = np.array([block.places_m for block in blocks])
        places[:, :, 2] = np.maximum(places[:, :, 2], LEAST_HEIGHT_M)
        flight_height_m = float(np.median(places[:, :, 2]))
        weights: FloatArray = np.full(POINTS, 1.0 / POINTS)
        if unit == OPEN_PATH:
            # A sum over the height is a mean times the height.
            lengths_m = places[:, :, 2].mean(axis=1)
            values, std = values / lengths_m, std / lengths_m
            places, weights = _down(places)
        vehicles = sorted({block.vehicle for block in blocks})
        first_s = min(block.time_s for block in blocks)
        survey = GasSurvey(
            places_m=places,
            weights=weights,
            wind_towards_mps=np.array([_wind_at(times, towards, b.time_s) for b in blocks]),
            values_g_m3=factor * values,
            std_g_m3=factor * std,
            is_below=np.zeros(len(values), bool),
            is_above=np.array([block.is_saturated for block in blocks]),
            times_s=np.array([block.time_s - first_s for block in blocks]),
            instruments=np.array([vehicles.index(block.vehicle) for block in blocks]),
            amount=amount.PARTICLES if known is PARTICLES else amount.GRAMS,
        )
        heights = [one.altitude_m - ground for one in self._winds.values()]
        return FlightSurvey(
            survey=survey,
            sensor=sensor,
            agent=known,
            wind_towards_mps=self.recent_wind(),
            anemometer_m=max(float(np.median(heights)), 2.0),
            flight_height_m=flight_height_m,
        )

    def recent_wind(self) -> tuple[float, float]:
        """Return the mean wind of the last `RECENT_S`, towards east and north, m/s."""
        newest_ns = self.newest_wind_ns
        recent = [
            (one.towards_east_mps, one.towards_north_mps)
            for one in self._winds.values()
            if newest_ns - one.time_ns <= RECENT_S * NS_PER_S
        ]
        east, north = np.mean(recent, axis=0).tolist()
        return east, north

    def _best_sensor(self) -> str:
        """Return the kind of sensor that shows the gas most clearly, and could see the agent."""
        able = {
            name: readings
            for name, readings in self._gases.items()
            if readings and self._response(next(iter(readings.values())))
        }
        if not able:
            raise NoSurveyError('no reading in ppm, or of particles, that could see the agent')
        # The noise of slow sensors is that of their readings without delay.
        contrasts = {name: _contrast(readings.values()) for name, readings in able.items()}
        return max(sorted(able), key=contrasts.__getitem__)

    def _response(self, reading: GasFlightReading) -> float:
        """Return the reading for 1 of the agent, ppm or particles; 1: the kind is not known."""
        is_of_particles = self._sampling.agent == PARTICLES.name
        if self._sampling.agent and (is_of_particles or reading.unit == PER_M3):
            return float(is_of_particles and reading.unit == PER_M3)
        if not self._sampling.agent or reading.sensor not in GAS_SENSORS:
            return 1.0
        return GAS_SENSORS[reading.sensor].response(agent(self._sampling.agent))

    def _scale(self, reading: GasFlightReading) -> tuple[Agent, float]:
        """Return the agent, and g/m^3 in the free air for 1 ppm read; of particles 1/m^3."""
        if reading.unit == PER_M3:
            return PARTICLES, 1.0 / self._sampling.dilution
        known = agent(self._sampling.agent or reading.calibration_gas)
        dilution = 1.0 if reading.unit == OPEN_PATH else self._sampling.dilution
        return known, known.g_m3(1.0) / (self._response(reading) * dilution)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Block:
    """Mean of readings that one vehicle took one after the other along `places_m`, (POINTS, 3)."""

    vehicle: str
    time_s: float
    places_m: FloatArray
    mean: float
    std: float
    is_saturated: bool


def _down(places_m: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points below places (n, k, 3), down to the ground, and weights of their mean.

    Each height is below another place of the way: time grows with the number of points.
    """
    below = places_m[:, 3 * np.arange(len(_NODES)) % places_m.shape[1]]
    below[:, :, 2] *= (_NODES + 1.0) / 2.0
    return below, np.asarray(_WEIGHTS / 2.0)


def _blocks(
    readings: Mapping[tuple[str, int], GasFlightReading], frame: LocalFrame, delay_s: float
) -> list[_Block]:
    """Return readings in blocks of one length for all vehicles."""
    ways: dict[str, list[GasFlightReading]] = {}
    for key in sorted(readings):
        ways.setdefault(key[0], []).append(readings[key])
    total_s = sum((way[-1].time_ns - way[0].time_ns) / NS_PER_S for way in ways.values())
    length_s = max(LEAST_BLOCK_S, total_s / MOST_BLOCKS)
    return [block for way in ways.values() for block in _way_blocks(way, frame, delay_s, length_s)]


def _way_blocks(
    way: Sequence[GasFlightReading], frame: LocalFrame, delay_s: float, length_s: float
) -> list[_Block]:
    times = np.array([one.time_ns for one in way]) / NS_PER_S
    places = np.array(
        [
            frame.enu_of(GeoPosition(one.latitude_deg, one.longitude_deg, one.altitude_m))
            for one in way
        ]
    )
    found = []
    numbers = ((times - times[0]) // length_s).astype(int)
    for number in np.unique(numbers):
        own = np.flatnonzero(numbers == number)
        # What is read now was beside the vehicle before.
        at = np.linspace(times[own[0]], times[own[-1]], POINTS) - delay_s
        line = np.column_stack([np.interp(at, times, places[:, axis]) for axis in range(3)])
        found.append(
            _Block(
                vehicle=way[0].vehicle,
                time_s=float(times[own].mean()),
                places_m=line,
                mean=float(np.mean([way[index].corrected for index in own])),
                std=math.hypot(*(way[index].std for index in own)) / len(own),
                is_saturated=any(way[index].is_saturated for index in own),
            )
        )
    return found


def _contrast(readings: Iterable[GasFlightReading]) -> float:
    """Return how far the highest readings are above the others, in their noise."""
    values = [one.corrected for one in readings]
    top, middle = np.quantile(values, (0.98, 0.5)).tolist()
    return float(top - middle) / max(_noise(values), 1e-12)


def _noise(values: Sequence[float]) -> float:
    """Return the standard deviation of values in clean air, from those below the median."""
    low, middle = np.quantile(values, (0.16, 0.5)).tolist()
    return float(middle - low)


def _sorted_winds(winds: Iterable[WindFlightReading]) -> tuple[FloatArray, FloatArray]:
    ordered = sorted(winds, key=lambda one: (one.time_ns, one.vehicle))
    times = np.array([one.time_ns for one in ordered]) / NS_PER_S
    towards = np.array([(one.towards_east_mps, one.towards_north_mps) for one in ordered])
    return times, towards


def _wind_at(times: FloatArray, towards: FloatArray, time_s: float) -> FloatArray:
    """Return the mean wind of the time before, or of all where there is none."""
    recent = towards[(times > time_s - WIND_S) & (times <= time_s + WIND_S / 4.0)]
    return np.asarray((recent if len(recent) else towards).mean(axis=0))
