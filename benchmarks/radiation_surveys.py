# SPDX-License-Identifier: Apache-2.0
"""Simulated surveys over known sources, and tables of measured values beside their targets."""

import argparse
import math
import re
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.counts_model import SOURCE_PARAMETERS
from rocsafe_radiation.localization.estimates import Localization
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.likelihood import Likelihood
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.physics.nuclide import nuclide
from rocsafe_radiation.physics.photons import AIR
from rocsafe_radiation.physics.shielding import Box
from rocsafe_radiation.physics.transmission import shielded_transmission
from rocsafe_radiation.readings.survey import RadiationSurvey

Row = tuple[str, str, str]
EXTENT_M, PITCH_M, HEIGHT_M = 300.0, 15.0, 32.0
SENSITIVITY, BACKGROUND_USVH = 550.0, 0.1
OPTIONS = LocalizationOptions(source_up_m=0.0, source_up_std_m=0.0)
CAESIUM_USVH_PER_GBQ = nuclide('Cs-137').dose_constant_usvh()
# A number; the minus between the bounds of a range is none of its own.
_NUMBER = re.compile(r'(?:(?<![\d.])-)?\d+(?:\.\d+)?(?:e[-+]?\d+)?')
# What a detector takes off for dead time by itself.
CORRECTED_DEAD_TIME_S = 5e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """What the truth is like where it differs from the estimator's model.

    Attributes
    ----------
    kernel: law of the dose rate.
    attenuation: share of each source's dose rate that is left.
    car: box about its own middle that stands beside each source, turned at random.
    position_noise_m, gain_noise: standard deviations of places and of the logarithm of gains.
    background_variation, background_lengths_m: standard deviation of the logarithm of the
        background, and the lengths of its waves.
    dead_time_s: after each hit, prolonged by hits; the detector takes off 5 us a count.
    """

    kernel: Kernel = OPTIONS.kernel
    attenuation: float = 1.0
    car: Box | None = None
    position_noise_m: float = 0.0
    gain_noise: float = 0.0
    background_variation: float = 0.0
    background_lengths_m: tuple[float, float] = (150.0, 400.0)
    dead_time_s: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """A survey with its truth and what was made of it."""

    truth: FloatArray
    found: Localization
    survey: RadiationSurvey
    seconds: float

    def errors_m(self) -> list[float]:
        """Return for each true source the distance to the nearest one found."""
        if not self.found.sources:
            return []
        places = np.array([source.position_enu_m[:2] for source in self.found.sources])
        return [float(np.hypot(*(places - place[:2]).T).min()) for place in self.truth]


def flown(generator: np.random.Generator, world: World, sources: FloatArray) -> RadiationSurvey:
    """Return the readings of a survey of `sources`: east, north, dose rate at 1 m in uSv/h."""
    axis = np.arange(0.0, EXTENT_M + 0.1, PITCH_M)
    east, north = (part.ravel() for part in np.meshgrid(axis, axis))
    places = np.stack([east, north, np.full(east.size, HEIGHT_M)], axis=1)
    waves = uneven(generator, places, world.background_lengths_m)
    rates = BACKGROUND_USVH * np.exp(world.background_variation * waves)
    for x, y, strength in sources:
        share = world.attenuation * _behind_car(generator, world.car, places - [x, y, 0.0])
        squares = (east - x) ** 2 + (north - y) ** 2 + HEIGHT_M**2
        rates = rates + share * strength * world.kernel.values(squares)
    gains = np.exp(generator.normal(0.0, world.gain_noise, east.size))
    hits = SENSITIVITY * rates * gains
    counts = generator.poisson(hits * np.exp(-hits * world.dead_time_s)).astype(float)
    places[:, :2] += generator.normal(0.0, world.position_noise_m, (east.size, 2))
    live_s = 1.0 - CORRECTED_DEAD_TIME_S * counts * (world.dead_time_s > 0.0)
    return RadiationSurvey(positions_enu_m=places, counts=counts, exposures=SENSITIVITY * live_s)


def _behind_car(
    generator: np.random.Generator, car: Box | None, rays: FloatArray
) -> FloatArray | float:
    """Return what a car that stands beside the source leaves along each ray, shape (n,)."""
    if car is None:
        return 1.0
    turn = generator.uniform(0.0, 2.0 * math.pi)
    cosine, sine = math.cos(turn), math.sin(turn)
    turned = rays @ np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    # Half a metre above the ground, one metre beside the car.
    start = np.array([[0.0, -car.size_m[1] / 2.0 - 1.0, 0.5]])
    inside = car.lengths_m(start, start + turned)[0]
    outside = np.linalg.norm(rays, axis=1) - inside
    behind = shielded_transmission('Cs-137', {AIR: outside, car.material: inside})
    return np.asarray(behind / shielded_transmission('Cs-137', {AIR: outside}))


def uneven(
    generator: np.random.Generator,
    places: FloatArray,
    lengths_m: tuple[float, float] = (150.0, 400.0),
) -> FloatArray:
    """Return a smooth random field of unit variance, made of waves of such lengths."""
    waves = 12
    lengths = generator.uniform(*lengths_m, waves)
    angles, phases = generator.uniform(0.0, 2.0 * math.pi, (2, waves))
    turns = places[:, :1] * np.cos(angles) + places[:, 1:2] * np.sin(angles)
    field = np.cos(2.0 * math.pi * turns / lengths + phases).sum(axis=1)
    return np.asarray(field * math.sqrt(2.0 / waves))


def drawn(
    generator: np.random.Generator, count: int, low_gbq: float, high_gbq: float
) -> FloatArray:
    """Return sources at random, at least 30 m apart and 30 m inside, log-uniform in activity."""
    places: list[FloatArray] = []
    while len(places) < count:
        place = generator.uniform(30.0, EXTENT_M - 30.0, 2)
        if all(np.hypot(*(place - other)) >= 30.0 for other in places):
            places.append(place)
    logs = generator.uniform(math.log(low_gbq), math.log(high_gbq), count)
    strengths = np.exp(logs) * CAESIUM_USVH_PER_GBQ
    return np.column_stack([np.array(places).reshape(count, 2), strengths])


def trials(
    seed: int, count: int, order: int, world: World, low_gbq: float = 1.0, high_gbq: float = 100.0
) -> Iterator[Trial]:
    """Yield `count` surveys of `order` sources, localised."""
    for index in range(count):
        generator = np.random.default_rng([seed, order, index])
        truth = drawn(generator, order, low_gbq, high_gbq)
        survey = flown(generator, world, truth)
        begin = time.process_time()
        found = localize(survey, OPTIONS)
        yield Trial(truth=truth, found=found, survey=survey, seconds=time.process_time() - begin)


def bound_m2(trial: Trial) -> FloatArray:
    """Return the Cramer-Rao bound of the place of each true source, shape (sources, 2, 2)."""
    likelihood = Likelihood(trial.survey, Setting(), np.empty((trial.survey.size, 0)))
    head = [math.log(BACKGROUND_USVH), *[0.0] * 3]
    places = [[x, y, 0.0, math.log(strength)] for x, y, strength in trial.truth]
    parameters = np.array([*head, *np.ravel(places)])
    information, _ = likelihood.information_and_gradient(parameters, np.ones(trial.survey.size))
    bound = np.linalg.inv(information)
    starts = range(len(head), len(bound), SOURCE_PARAMETERS)
    return np.stack([bound[start : start + 2, start : start + 2] for start in starts])


def errors_at_bound_m(results: list[Trial]) -> FloatArray:
    """Return distances that an estimator at the bound would miss by, 100 for each source."""
    generator = np.random.default_rng(0)
    ways = [
        generator.multivariate_normal(np.zeros(2), bound, 100)
        for trial in results
        for bound in bound_m2(trial)
    ]
    return np.asarray(np.hypot(*np.concatenate(ways).T))


def print_table(
    description: str, parts: Mapping[str, Callable[[int], Iterator[Row]]], width: int = 62
) -> None:
    """Print what the parts named on the command line measure, each row as soon as it is known."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument('--trials', type=int, default=200, metavar='N', help='surveys a row')
    parser.add_argument('--only', nargs='+', choices=list(parts), default=list(parts))
    arguments = parser.parse_args()
    print(f'{"what":{width}} {"target":>10} {"measured":>12}')
    for part in arguments.only:
        for what, target, measured in parts[part](arguments.trials):
            outcome = judged(target, measured)
            print(f'{what:{width}} {target:>10} {measured:>12}  {outcome}'.rstrip(), flush=True)


def judged(target: str, measured: str) -> str:
    """Return ``met`` or ``missed``; empty without a target."""
    if not target:
        return ''
    value, *limits = (float(part) for part in _NUMBER.findall(f'{measured} {target}'))
    if target.startswith('<='):
        is_met = value <= limits[-1]
    elif target.startswith('>='):
        is_met = value >= limits[-1]
    elif target.startswith('>'):
        is_met = value > limits[-1]
    else:
        is_met = limits[-2] <= value <= limits[-1]
    return 'met' if is_met else 'missed'
