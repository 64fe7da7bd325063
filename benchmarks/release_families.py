# SPDX-License-Identifier: Apache-2.0
"""Simulated releases that are searched for, drawn from ranges, by splits; the truth is filaments.

Each trial draws everything anew:

    releases    0 to 3 (the number of the trial modulo 4), 0.2 to 8 g/s at 0.5 m, 80 x 80 m
    air         stability A to F, wind of 1.5 to 7 m/s from anywhere
    eddies      shares and time scales of the filaments: `_filaments`
    detector    one of `DETECTORS`: noise of 3e-5 to 2e-4 g/m^3, and what its kind adds
    background  0 to 5 times the noise
    places      one of `PATTERNS`, 60 readings of 2 to 10 s at 2 to 4 m, one in 8 to 15 s

What the estimator is told of the air is wrong: the direction of the wind by 5 degrees (one
standard deviation; 10 in every fourth trial), its speed by 10 %, and each reading has a direction
of its own (3 degrees). The stability told is the true one in half of the trials, one beside it in
a quarter, and D in a quarter.

Splits have seeds of their own: ``develop`` and ``validate`` may be looked at while a method is
changed, ``opened`` only once, for the figures that are stated.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_dispersion.estimation.gas_survey import GasSurvey, point_survey
from rocsafe_dispersion.plume.filaments import FilamentCloud, FilamentOptions
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.stability import CLASSES, StabilityClass, layer_of_class
from rocsafe_geo.wind.wind_field import ProfileWind
from rocsafe_geo.wind.wind_vector import WindVector

SPLITS = {'develop': 11, 'validate': 12, 'opened': 13}
DETECTORS = ('plain', 'drifting', 'relative', 'limited')
PATTERNS = ('mower', 'crosswind', 'scattered', 'circles')
ROUGHNESS_M, ANEMOMETER_M, RELEASE_M = 0.03, 10.0, 0.5
# Half the side of the ground with releases, and of that with readings, metres.
RELEASES_WITHIN_M, READINGS_WITHIN_M = 40.0, 46.0
READINGS, INSTANTS = 60, 8
# Older filaments have left the ground: 130 m in the slowest wind near the ground.
OLDEST_S = 200.0
# Detectors: a zero that wanders, in noises; noise as a share of the reading; limit, in noises.
DRIFT, DRIFT_S, RELATIVE, LIMIT = 2.0, 600.0, 0.15, 4.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trial:
    """Releases in the air, and what is told of the air.

    Attributes
    ----------
    places_m, rates_g_s
        Releases, (k, 2) and (k,).
    told_mps, told_stability
        What the estimator is told.
    true_stability
        True class of stability.
    detector, pattern
        Of `DETECTORS` and `PATTERNS`.
    noise_g_m3, background_g_m3
        Of the detector.
    reading_s, between_s, sensor_m
        Length of a reading and time from one to the next, seconds; height, metres.
    wind, eddies
        True wind, and how intermittent gas is in it.
    clouds
        Filaments of each release.
    generator
        Draws the noise of the readings.
    """

    places_m: FloatArray
    rates_g_s: FloatArray
    told_mps: FloatArray
    told_stability: StabilityClass
    true_stability: StabilityClass
    detector: str
    pattern: str
    noise_g_m3: float
    background_g_m3: float
    reading_s: float
    between_s: float
    sensor_m: float
    wind: ProfileWind
    eddies: FilamentOptions
    clouds: tuple[FilamentCloud, ...]
    generator: np.random.Generator

    def survey(self, places_m: FloatArray, first: int = 0) -> GasSurvey:
        """Return readings at places, (n, 3); `first` is the number of the first one."""
        count = len(places_m)
        times: FloatArray = OLDEST_S + self.between_s * (first + np.arange(count, dtype=float))
        offsets = self.reading_s / INSTANTS * np.arange(INSTANTS)
        values: FloatArray = np.full(count, self.background_g_m3)
        for cloud in self.clouds:
            for number, place in enumerate(places_m):
                found = [
                    cloud.at(times[number] + offset).concentrations_g_m3(place[None])[0]
                    for offset in offsets.tolist()
                ]
                values[number] += float(np.mean(found))
        white = self.generator.standard_normal(count)
        noise: FloatArray = np.full(count, self.noise_g_m3)
        if self.detector == 'relative':
            noise = np.hypot(noise, RELATIVE * values)
        values = values + noise * white
        if self.detector == 'drifting':
            values = values + DRIFT * self.noise_g_m3 * self._wandering(count)
        limit = self.background_g_m3 + LIMIT * self.noise_g_m3
        is_below = (values < limit) & (self.detector == 'limited')
        turns = np.radians(3.0) * self.generator.standard_normal(count)
        winds = np.array([turned(self.told_mps, turn) for turn in turns])
        std = np.full(count, self.noise_g_m3)
        values = np.where(is_below, limit, values)
        return point_survey(places_m, winds, values, std, times, is_below=is_below)

    def _wandering(self, count: int) -> FloatArray:
        """Return noise of variance 1 with the time scale `DRIFT_S`."""
        rho = math.exp(-self.between_s / DRIFT_S)
        white = self.generator.standard_normal(count)
        zero = white.copy()
        for number in range(1, count):
            zero[number] = rho * zero[number - 1] + math.sqrt(1.0 - rho * rho) * white[number]
        return zero

    def places(self) -> FloatArray:
        """Return the places of its pattern, (n, 3)."""
        flat = {
            'mower': lawn_mower, 'crosswind': self._crosswind, 'scattered': self._scattered,
            'circles': circles,
        }[self.pattern]()  # fmt: skip
        return np.column_stack([flat, np.full(len(flat), self.sensor_m)])

    def _crosswind(self) -> FloatArray:
        """Return places along four lines across the wind, (n, 2)."""
        downwind = self.told_mps / np.hypot(*self.told_mps)
        across = np.array([-downwind[1], downwind[0]])
        offsets = np.linspace(-READINGS_WITHIN_M, READINGS_WITHIN_M, READINGS // 4)
        rows = [
            along * downwind + (side if number % 2 == 0 else -side) * across
            for number, along in enumerate((-30.0, -10.0, 12.0, 36.0))
            for side in offsets
        ]
        return np.array(rows)

    def _scattered(self) -> FloatArray:
        """Return places drawn evenly, (n, 2)."""
        return self.generator.uniform(-READINGS_WITHIN_M, READINGS_WITHIN_M, (READINGS, 2))


def turned(vector: FloatArray, angle_rad: float) -> FloatArray:
    """Return a vector turned anticlockwise."""
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cosine, -sine], [sine, cosine]]) @ vector


def lawn_mower(count: int = READINGS) -> FloatArray:
    """Return about `count` places along lines to the north and back, (n, 2)."""
    lines = max(round(math.sqrt(count)), 2)
    axis = np.linspace(-READINGS_WITHIN_M, READINGS_WITHIN_M, lines)
    along = np.linspace(-READINGS_WITHIN_M, READINGS_WITHIN_M, max(count // lines, 2))
    rows = [
        (east, north * (1.0 if number % 2 == 0 else -1.0))
        for number, east in enumerate(axis)
        for north in along
    ]
    return np.array(rows)


def circles() -> FloatArray:
    """Return places along three circles about the middle, (n, 2)."""
    rows = [
        (radius * math.cos(angle), radius * math.sin(angle))
        for radius, count in ((15.0, 12), (30.0, 20), (45.0, 28))
        for angle in np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    ]
    return np.array(rows)


def trial(split: str, number: int, turned_deg: float = 0.0) -> Trial:
    """Return one trial; the wind that is told is turned by an angle besides."""
    generator = np.random.default_rng([SPLITS[split], number])
    true = int(generator.integers(len(CLASSES)))
    speed, angle = generator.uniform(1.5, 7.0), generator.uniform(0.0, 2.0 * math.pi)
    towards = speed * np.array([math.cos(angle), math.sin(angle)])
    layer = layer_of_class(CLASSES[true], speed, ANEMOMETER_M, ROUGHNESS_M)
    count = number % 4
    places = generator.uniform(-RELEASES_WITHIN_M, RELEASES_WITHIN_M, (count, 2))
    rates = np.exp(generator.uniform(math.log(0.2), math.log(8.0), count))
    error = math.radians(10.0 if generator.random() < 0.25 else 5.0) * generator.standard_normal()
    error += math.radians(turned_deg)
    noise = math.exp(generator.uniform(math.log(3e-5), math.log(2e-4)))
    wind = ProfileWind(
        layer=layer,
        wind=WindVector(towards_east_mps=float(towards[0]), towards_north_mps=float(towards[1])),
    )
    travel, options = similarity_travel(layer, RELEASE_M), _filaments(generator)
    return Trial(
        places_m=places,
        rates_g_s=rates,
        told_mps=turned(towards, float(error)) * math.exp(0.1 * generator.standard_normal()),
        told_stability=_told(generator, true),
        true_stability=CLASSES[true],
        detector=str(generator.choice(DETECTORS)),
        pattern=str(generator.choice(PATTERNS)),
        noise_g_m3=noise,
        background_g_m3=float(generator.uniform(0.0, 5.0)) * noise,
        reading_s=float(generator.uniform(2.0, 10.0)),
        between_s=float(generator.uniform(8.0, 15.0)),
        sensor_m=float(generator.uniform(2.0, 4.0)),
        wind=wind,
        eddies=options,
        clouds=tuple(
            FilamentCloud(
                Release(place_m=(x, y), height_m=RELEASE_M, rate_g_s=rate), travel, wind,
                int(generator.integers(2**31)), options,
            )
            for (x, y), rate in zip(places.tolist(), rates.tolist(), strict=True)
        ),
        generator=generator,
    )  # fmt: skip


def _filaments(generator: np.random.Generator) -> FilamentOptions:
    """Return how intermittent the gas is."""
    return replace(
        FilamentOptions(longest_s=OLDEST_S),
        size_share=float(generator.uniform(0.2, 0.5)),
        meander_share=float(generator.uniform(0.3, 0.8)),
        meander_s=math.exp(generator.uniform(math.log(3.0), math.log(20.0))),
        eddy_s=float(generator.uniform(0.5, 2.0)),
    )


def _told(generator: np.random.Generator, true: int) -> StabilityClass:
    """Return the class of stability that is told."""
    beside = true + (1 if true == 0 or (true < 5 and generator.random() < 0.5) else -1)
    return (CLASSES[true], CLASSES[true], CLASSES[beside], 'D')[int(generator.integers(4))]
