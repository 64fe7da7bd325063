# SPDX-License-Identifier: Apache-2.0
"""A search for one source: drones fly from place to place and read their sensors."""

import math
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import (
    require_between,
    require_count,
    require_not_negative,
    require_positive,
)
from rocsafe_geo.motion.leg import leg_duration_s
from rocsafe_geo.motion.performance import Performance
from rocsafe_learning.sensing.gamma_sensor import GammaSensor
from rocsafe_learning.sensing.sensor_model import SensorModel
from rocsafe_learning.source_belief import BeliefTables, Place, SourceBelief

TABLE_ROWS = 2048


def default_performance() -> Performance:
    """Return the limits of a small multirotor."""
    return Performance(
        cruise_speed_mps=8.0, acceleration_mps2=3.0, climb_rate_mps=3.0, descent_rate_mps=2.0
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """What is searched, how, and what it is worth.

    Attributes
    ----------
    sensor
        What the drones read.
    area_m
        Side of the square that holds the source, metres.
    vehicles
        Number of drones.
    performance
        Limits of their flight.
    readings
        Readings of each drone at most.
    placed_m
        The source is found when the root mean square distance from its mean place is at most
        this, metres.
    reward_per_nat, reward_per_s, reward_found
        Reward of a decrease of the belief's entropy, of a second of time, and of finding.
    """

    sensor: SensorModel = field(default_factory=GammaSensor)
    area_m: float = 100.0
    vehicles: int = 1
    performance: Performance = field(default_factory=default_performance)
    readings: int = 60
    placed_m: float = 4.0
    reward_per_nat: float = 1.0
    reward_per_s: float = -0.02
    reward_found: float = 5.0

    def __post_init__(self) -> None:
        require_between('area_m', self.area_m, 10.0, 10_000.0, 'm')
        require_count('vehicles', self.vehicles, 1, 100)
        require_count('readings', self.readings, 1, 100_000)
        require_positive('placed_m', self.placed_m, 'm')
        require_not_negative('reward_found', self.reward_found)


@dataclass(frozen=True, slots=True, kw_only=True)
class Truth:
    """What the drones look for: east and north in metres, and strength."""

    place_m: Place
    strength: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Round:
    """What one round of readings brought: nats won, seconds taken, whether the source is found."""

    gain_nats: float
    duration_s: float
    is_found: bool
    reward: float


class SourceSearch:
    """One search after another; drones share one belief.

    Parameters
    ----------
    options
        What is searched.
    """

    def __init__(self, options: SearchOptions) -> None:
        self.options = options
        self._tables = BeliefTables.of(options.sensor, options.area_m)
        # A table of all flights that fit the area: a step of a search takes microseconds.
        self._step_m = options.area_m / TABLE_ROWS
        distances: FloatArray = self._step_m * np.arange(2 * TABLE_ROWS, dtype=np.float64)
        self._durations_s = leg_duration_s(distances, options.performance.level).tolist()
        self.begin(np.random.default_rng(0))

    def begin(self, generator: np.random.Generator) -> None:
        """Begin a search with a source drawn anew; all drones are in the south-west."""
        side = self.options.area_m
        east, north = generator.uniform(0.0, side, 2).tolist()
        strength = float(self.options.sensor.strengths(generator.uniform(0.0, 1.0, 1))[0])
        self.truth = Truth(place_m=(east, north), strength=strength)
        self.belief = SourceBelief(self._tables)
        self.places_m: list[Place] = [(0.0, 0.0)] * self.options.vehicles
        self.last_readings = [0.0] * self.options.vehicles
        self.count = 0
        self.time_s = 0.0

    def advance(self, targets_m: list[Place], generator: np.random.Generator) -> Round:
        """Let every drone fly to its target and read; those that arrive early wait.

        Parameters
        ----------
        targets_m
            East and north for each drone; places outside the area are moved to its edge.
        generator
            What draws the readings.
        """
        gain, longest_s = 0.0, 0.0
        for index, target in enumerate(targets_m):
            place = self.rounded_m(target)
            distance = math.dist(place, self.places_m[index])
            longest_s = max(longest_s, self._leg_s(distance))
            self.places_m[index] = place
            reading = self._read(place, generator)
            self.last_readings[index] = reading
            gain += self.belief.add(place, reading)
        self.count += 1
        self.time_s += longest_s
        return self._round(gain, longest_s)

    @property
    def is_over(self) -> bool:
        """Whether all readings are taken."""
        return self.count >= self.options.readings

    def error_m(self) -> float:
        """Return how far the mean place is from the true one, metres."""
        return math.dist(self.belief.mean_and_spread_m()[0], self.truth.place_m)

    def leg_s(self, start_m: Place, end_m: Place) -> float:
        """Return the time of a flight between two places, seconds."""
        return self._leg_s(math.dist(start_m, end_m))

    def rounded_m(self, place_m: Place) -> Place:
        """Return the nearest place within the area where a reading can be, metres."""
        side = self.options.area_m
        east, north = (min(max(value, 0.0), side) for value in place_m)
        return self._tables.rounded_m((east, north))

    def _leg_s(self, distance_m: float) -> float:
        row, share = divmod(distance_m / self._step_m, 1.0)
        low, high = self._durations_s[int(row) : int(row) + 2]
        return low + share * (high - low)

    def _read(self, place_m: Place, generator: np.random.Generator) -> float:
        east, north = self.truth.place_m
        offset = (place_m[0] - east, place_m[1] - north)
        return self.options.sensor.draw(offset, self.truth.strength, generator)

    def _round(self, gain_nats: float, duration_s: float) -> Round:
        options = self.options
        is_found = self.belief.mean_and_spread_m()[1] <= options.placed_m
        reward = options.reward_per_nat * gain_nats + options.reward_per_s * duration_s
        return Round(
            gain_nats=gain_nats,
            duration_s=duration_s,
            is_found=is_found,
            reward=reward + (options.reward_found if is_found else 0.0),
        )
