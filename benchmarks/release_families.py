# SPDX-License-Identifier: Apache-2.0
"""Simulated releases that are searched for, by families and splits; the truth is filaments.

A trial is drawn from ranges: stability A to F, wind of 1.5 to 6 m/s from anywhere, one release of
0.3 to 5 g/s at 0.5 m above the ground within 80 x 80 m, readings of 5 s at 3 m above the ground
with noise and a background, whose zero wanders in every other trial (by twice the noise in 10
minutes). What the estimator is told of the air is wrong: the direction of the
wind by 5 degrees (one standard deviation), its speed by 10 %, and each reading has a direction of
its own (3 degrees). Families differ from ``even`` by one thing:

    wind        the direction is wrong by 10 degrees
    stability   the class that is told is one beside the true one
    two         two releases
    none        no release

Splits have seeds of their own: ``develop`` and ``validate`` may be looked at while a method is
changed, ``opened`` only once, for the figures that are stated.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.plume.filaments import FilamentCloud, FilamentOptions
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.stability import CLASSES, StabilityClass, layer_of_class
from rocsafe_geo.wind.wind_field import ProfileWind
from rocsafe_geo.wind.wind_vector import WindVector

SPLITS = {'develop': 1, 'validate': 2, 'opened': 3}
FAMILIES = ('even', 'wind', 'stability', 'two', 'none')
ROUGHNESS_M, ANEMOMETER_M, RELEASE_M, SENSOR_M = 0.03, 10.0, 0.5, 3.0
NOISE_G_M3 = 5e-5
# Half the side of the ground with releases, and of that with readings, metres.
RELEASES_WITHIN_M, READINGS_WITHIN_M = 40.0, 46.0
READING_S, INSTANTS, BETWEEN_S = 5.0, 10, 12.0
# Older filaments have left the ground: 130 m in the slowest wind near the ground.
OLDEST_S = 200.0
MOST_READINGS, DRIFT_G_M3, DRIFT_S = 200, 2.0 * NOISE_G_M3, 600.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """Releases in the air, and what is told of the air.

    Attributes
    ----------
    family
        What it is of.
    places_m, rates_g_s
        Releases, (k, 2) and (k,).
    towards_mps
        True mean wind.
    told_mps, told_stability
        What the estimator is told.
    true_stability
        True class of stability.
    background_g_m3
        Background.
    drift : (MOST_READINGS,)
        What wanders is added to each reading of the flight, g/m^3.
    clouds
        Filaments of each release.
    generator
        Draws the noise of the readings.
    """

    family: str
    places_m: FloatArray
    rates_g_s: FloatArray
    towards_mps: FloatArray
    told_mps: FloatArray
    told_stability: StabilityClass
    true_stability: StabilityClass
    background_g_m3: float
    drift: FloatArray
    clouds: tuple[FilamentCloud, ...]
    generator: np.random.Generator

    def readings(self, places_m: FloatArray, first: int) -> tuple[FloatArray, FloatArray]:
        """Return values, g/m^3, and winds of readings at places, (n, 3).

        `first` is the number of the first reading of these in the whole flight.
        """
        values = np.full(len(places_m), self.background_g_m3)
        for number, place in enumerate(places_m):
            start = OLDEST_S + BETWEEN_S * (first + number)
            for cloud in self.clouds:
                instants = start + READING_S / INSTANTS * np.arange(INSTANTS)
                found = [cloud.at(float(t)).concentrations_g_m3(place[None])[0] for t in instants]
                values[number] += float(np.mean(found))
        values += self.drift[first : first + len(places_m)]
        values += NOISE_G_M3 * self.generator.standard_normal(len(places_m))
        turns = np.radians(3.0) * self.generator.standard_normal(len(places_m))
        return values, np.array([turned(self.told_mps, turn) for turn in turns])


def turned(vector: FloatArray, angle_rad: float) -> FloatArray:
    """Return a vector turned anticlockwise."""
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cosine, -sine], [sine, cosine]]) @ vector


def trial(split: str, family: str, number: int) -> Trial:
    """Return one trial; the same arguments give the same trial."""
    generator = np.random.default_rng([SPLITS[split], FAMILIES.index(family), number])
    true = int(generator.integers(len(CLASSES)))
    beside = true + (1 if true == 0 or (true < 5 and generator.random() < 0.5) else -1)
    speed, angle = generator.uniform(1.5, 6.0), generator.uniform(0.0, 2.0 * math.pi)
    towards = speed * np.array([math.cos(angle), math.sin(angle)])
    layer = layer_of_class(CLASSES[true], speed, ANEMOMETER_M, ROUGHNESS_M)
    wind = ProfileWind(
        layer=layer,
        wind=WindVector(towards_east_mps=float(towards[0]), towards_north_mps=float(towards[1])),
    )
    travel = similarity_travel(layer, RELEASE_M)
    count = {'two': 2, 'none': 0}.get(family, 1)
    places = generator.uniform(-RELEASES_WITHIN_M, RELEASES_WITHIN_M, (count, 2))
    rates = np.exp(generator.uniform(math.log(0.3), math.log(5.0), count))
    error = math.radians(10.0 if family == 'wind' else 5.0) * generator.standard_normal()
    told = turned(towards, float(error)) * math.exp(0.1 * generator.standard_normal())
    return Trial(
        family=family,
        places_m=places,
        rates_g_s=rates,
        towards_mps=towards,
        told_mps=told,
        told_stability=CLASSES[beside if family == 'stability' else true],
        true_stability=CLASSES[true],
        background_g_m3=float(generator.uniform(0.0, 5.0 * NOISE_G_M3)),
        drift=wandering(generator) * (number % 2),
        clouds=tuple(
            FilamentCloud(
                Release(place_m=(x, y), height_m=RELEASE_M, rate_g_s=rate), travel, wind,
                int(generator.integers(2**31)), FilamentOptions(longest_s=OLDEST_S),
            )
            for (x, y), rate in zip(places.tolist(), rates.tolist(), strict=True)
        ),
        generator=generator,
    )  # fmt: skip


def wandering(generator: np.random.Generator) -> FloatArray:
    """Return the zero of a sensor at each reading, (MOST_READINGS,), g/m^3."""
    rho = math.exp(-BETWEEN_S / DRIFT_S)
    zero = np.empty(MOST_READINGS)
    zero[0] = generator.standard_normal()
    for number in range(1, MOST_READINGS):
        step = math.sqrt(1.0 - rho * rho) * generator.standard_normal()
        zero[number] = rho * zero[number - 1] + step
    return np.asarray(DRIFT_G_M3 * zero)


def trials(split: str, count: int) -> Iterator[tuple[int, Trial]]:
    """Yield `count` trials of each family."""
    for number in range(count):
        for family in FAMILIES:
            yield number, trial(split, family, number)


def lawn_mower(count: int) -> FloatArray:
    """Return about `count` places along lines to the north and back, (n, 3)."""
    lines = max(round(math.sqrt(count)), 2)
    axis = np.linspace(-READINGS_WITHIN_M, READINGS_WITHIN_M, lines)
    along = np.linspace(-READINGS_WITHIN_M, READINGS_WITHIN_M, max(count // lines, 2))
    rows = [
        (east, north * (1.0 if number % 2 == 0 else -1.0), SENSOR_M)
        for number, east in enumerate(axis)
        for north in along
    ]
    return np.array(rows)


def crosswind(count: int, told_mps: FloatArray) -> FloatArray:
    """Return about `count` places along four lines across the wind, the same ground, (n, 3)."""
    downwind = told_mps / np.hypot(*told_mps)
    across = np.array([-downwind[1], downwind[0]])
    rows = []
    for number, along in enumerate((-30.0, -10.0, 12.0, 36.0)):
        for offset in np.linspace(-READINGS_WITHIN_M, READINGS_WITHIN_M, count // 4):
            side = offset if number % 2 == 0 else -offset
            rows.append((*(along * downwind + side * across), SENSOR_M))
    return np.array(rows)
