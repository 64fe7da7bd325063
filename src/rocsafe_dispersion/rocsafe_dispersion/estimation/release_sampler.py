# SPDX-License-Identifier: Apache-2.0
"""Samples of the posterior of a number of releases, and the evidence of that number.

Sequential Monte Carlo (Del Moral and others 2006): hypotheses are drawn from the prior, the
likelihood is raised to a power that grows from 0 to 1, and at each power hypotheses are resampled
and moved. Moves are differences of two other hypotheses (differential evolution, ter Braak 2006),
which follow correlations and jump between separate modes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy import optimize, special

from rocsafe_dispersion.estimation.background_filter import BackgroundFilter
from rocsafe_dispersion.estimation.fluctuating_plume import PlumeReadings, Shapes
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_geo.arrays import BoolArray, FloatArray, IndexArray

# Before readings: the meander is even between 0 and its largest share; medians and standard
# deviations of the logarithms of the intensity within the moving plume, of the factor of the
# noise, and of the drift in the whole time, in noises. They are choices, wide enough for what
# `benchmarks/release_families.py` draws.
_MOST_MEANDER = 0.9
# Probability that a release of the kind `LIMITED` has started before the readings; it is the same
# that the release ends after them.
_LASTING = 0.5
# Moves that are tried go anywhere: probabilities of turns stay so far from 0 and 1.
_LEAST_TAIL = 1e-9
_RELATIVE, _RELATIVE_STD = 0.4, 0.5
_NOISE_STD = 0.25
# Nor is the noise further from the one told than this: readings that are all alike would make it
# nothing, and then anything explains them.
_MOST_NOISE_STDS = 4.0
_DRIFT, _DRIFT_STD = 0.3, 1.5
# Probability before readings that a release is beyond each pair of edges of the ground; it is then
# up to the longer side of the ground away from it.
_BEYOND = 0.05
# Coordinates that all releases share, see `shapes_of`, `spans_of` and `ways_of`; of each release.
# The last shared one is the kind of a hypothesis; it is not moved.
SHARED, OWN = 10, 3
KIND = 9
_ESS_SHARE = 0.7
# Hypotheses times points of readings, and hypotheses that are never fewer: large surveys take
# as many as time allows. Small ones take more: up to so many times, below so many points.
_MOST_PAIRS, _FEWEST = 120_000, 200
_MOST_TIMES, _SMALL = 3.0, 100


@dataclass(frozen=True, slots=True, kw_only=True)
class Bounds:
    """What releases may be.

    Attributes
    ----------
    edges_m
        Of the ground with releases: west, south, east, north. One may be beyond, see `places_of`.
    rates_g_s
        Least and largest rate.
    times_s
        Times of the first and the last reading: releases start between them, or before, and end
        between them, or after, all at the same times; None: long before and after.
    """

    edges_m: tuple[float, float, float, float]
    rates_g_s: tuple[float, float]
    times_s: tuple[float, float] | None = None


@dataclass(slots=True, kw_only=True, eq=False)
class Population:
    """Hypotheses (p): shared coordinates (p, SHARED), releases (p, k, OWN), and their readings.

    Shared coordinates are standard normal before readings, but for `KIND`; those of a
    release are even in 0 to 1. `means` and `spreads` (p, k, n) are for the rates; `backgrounds`
    (p, instruments).
    """

    shared: FloatArray
    own: FloatArray
    means: FloatArray
    spreads: FloatArray
    logs: FloatArray
    backgrounds: FloatArray

    def take(self, index: FloatArray) -> None:
        """Keep the hypotheses of an index."""
        for name in ('shared', 'own', 'means', 'spreads', 'logs', 'backgrounds'):
            setattr(self, name, getattr(self, name)[index])

    @classmethod
    def mixed(cls, parts: Sequence['Population'], shares: FloatArray) -> 'Population':
        """Return as many hypotheses as each population has, some of each by their shares."""
        count = len(parts[0].logs)
        counts = np.diff(np.rint(np.cumsum([0.0, *shares]) * count).astype(int))
        # Each stands in the order of its ancestors: those taken are spread evenly.
        taken = [np.arange(own) * count // max(own, 1) for own in counts.tolist()]
        return cls(**{
            name: np.concatenate([
                getattr(part, name)[index] for part, index in zip(parts, taken, strict=True)
            ])
            for name in cls.__dataclass_fields__
        })  # fmt: skip

    def accept(self, other: 'Population', is_taken: BoolArray) -> None:
        """Take those hypotheses of another population."""
        for name in ('shared', 'own', 'means', 'spreads', 'logs', 'backgrounds'):
            getattr(self, name)[is_taken] = getattr(other, name)[is_taken]


class Kind(IntEnum):
    """What a hypothesis takes for true."""

    AS_TOLD = 0
    WRONG_WIND = 1
    LIMITED = 2
    MOVES = 3


class ReleaseSampler:
    """Samples numbers of releases for one survey."""

    def __init__(
        self,
        readings: PlumeReadings,
        backgrounds: BackgroundFilter,
        bounds: Bounds,
        options: LocateOptions,
        generator: np.random.Generator,
    ) -> None:
        self._readings, self._backgrounds, self._bounds = readings, backgrounds, bounds
        self._options, self._generator = options, generator

    def shapes_of(self, shared: FloatArray) -> Shapes:
        """Return the shapes of plumes of shared coordinates."""
        options = self._options
        even = np.clip(special.ndtr(shared[:, 0]), _LEAST_TAIL, 1.0 - _LEAST_TAIL)
        turn_deg = np.where(
            shared[:, KIND] == Kind.WRONG_WIND,
            360.0 * even,
            options.turn_std_deg * _student_quantile(even),
        )
        return Shapes(
            turn_rad=np.radians(turn_deg),
            spread_y=np.exp(options.spread_std * shared[:, 1]),
            spread_z=np.exp(options.spread_std * shared[:, 2]),
            meander=_MOST_MEANDER * special.ndtr(shared[:, 3]),
            relative=_RELATIVE * np.exp(_RELATIVE_STD * shared[:, 4]),
        )

    def places_of(self, own: FloatArray) -> FloatArray:
        """Return places, (..., 2), of coordinates of releases."""
        west, south, east, north = self._bounds.edges_m
        reach = max(east - west, north - south)
        shares = (0.0, _BEYOND / 2.0, 1.0 - _BEYOND / 2.0, 1.0)
        return np.stack([
            np.interp(own[..., axis], shares, (low - reach, low, high, high + reach))
            for axis, (low, high) in enumerate(((west, east), (south, north)))
        ], axis=-1)  # fmt: skip

    def rates_of(self, own: FloatArray) -> FloatArray:
        """Return rates of coordinates of releases, g/s."""
        low, high = self._bounds.rates_g_s
        return np.asarray(low * (high / low) ** own[..., 2])

    def spans_of(self, shared: FloatArray) -> FloatArray | None:
        """Return start and end of releases of shared coordinates, (2, p), s; None: not known.

        Infinite: before the first reading, and after the last one.
        """
        if self._bounds.times_s is None:
            return None
        first_s, last_s = self._bounds.times_s
        shares = (special.ndtr(shared[:, 7:9].T) - _LASTING) / (1.0 - _LASTING)
        shares[(shares < 0.0) | (shared[:, KIND] != Kind.LIMITED)] = -np.inf
        # Ends are counted back from the last reading.
        long_s = shares * (last_s - first_s)
        return np.stack([first_s + long_s[0], last_s - long_s[1]])

    def ways_of(self, own: FloatArray, shared: FloatArray) -> FloatArray | None:
        """Return the ways of releases, (p, 2), from the first reading to the last one, metres.

        Before readings it was at first where it may be at last. None: all stand.
        """
        moves = shared[:, KIND] == Kind.MOVES
        if not moves.any():
            return None
        first = self.places_of(special.ndtr(shared[:, 7:9]))
        return np.where(moves[:, None], self.places_of(own) - first, 0.0)

    def kinds(self, number: int) -> dict[Kind, float]:
        """Kinds of hypotheses of a number of releases beside those as told.

        With their probabilities before readings.
        """
        found = {Kind.WRONG_WIND: self._options.wrong_wind}
        if self._bounds.times_s is not None:
            found[Kind.LIMITED] = self._options.limited
            if number == 1:
                found[Kind.MOVES] = self._options.moves
        return found

    def sample(self, number: int, kind: Kind = Kind.AS_TOLD) -> tuple[Population, float]:
        """Return hypotheses with a number of releases, and the logarithm of their evidence.

        Their wind is about the one told, or, if that is wrong, from anywhere; they last all the
        time, or start or end among the readings; they stand or move.
        """
        points, wanted = self._readings.points, self._options.particles
        times = min(max(_SMALL / points, 1.0), _MOST_TIMES)
        count = max(min(int(times * wanted), _MOST_PAIRS // points), min(_FEWEST, wanted))
        shared = self._generator.standard_normal((count, SHARED))
        shared[:, KIND] = kind
        own = self._generator.random((count, number, OWN))
        now = self._made(shared, own)
        power = evidence = 0.0
        while power < 1.0:
            step = _next_step(now.logs, 1.0 - power)
            weights = step * now.logs
            evidence += float(special.logsumexp(weights) - np.log(count))
            power += step
            now.take(self._resampled(np.exp(weights - weights.max())))
            self._move(now, power)
        return now, evidence

    def gains_of_one_more(
        self, now: Population, index: IndexArray, places_m: FloatArray, rates_g_s: FloatArray
    ) -> FloatArray:
        """Return logarithms of the likelihood of a release more over none, (r, q).

        One of each rate, (r,), at each place, (q, 2), beside the hypotheses `index`, (q,).
        """
        found = np.empty((len(rates_g_s), len(index)))
        for start in range(0, len(index), len(now.logs)):
            rows = slice(start, start + len(now.logs))
            own = index[rows]
            mean, spread = self._readings.of(places_m[rows], self.shapes_of(now.shared[own]))
            for number, rate_g_s in enumerate(rates_g_s.tolist()):
                logs, _ = self._log_likelihoods(
                    now.shared[own],
                    np.concatenate([now.means[own], rate_g_s * mean[:, None]], axis=1),
                    np.concatenate([now.spreads[own], rate_g_s * spread[:, None]], axis=1),
                )
                found[number, rows] = logs - now.logs[own]
        return found

    def reading_logs(self, now: Population) -> FloatArray:
        """Return logarithms of the likelihood of each reading, given those before, (p, n)."""
        each = np.zeros((len(now.logs), self._backgrounds.readings))
        self._log_likelihoods(now.shared, now.means, now.spreads, each)
        return each

    def _log_likelihoods(
        self,
        shared: FloatArray,
        means: FloatArray,
        spreads: FloatArray,
        each: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Return logarithms of the likelihood and backgrounds; means are (p, releases, n)."""
        return self._backgrounds.log_likelihoods(
            means.sum(axis=1),
            np.sqrt((spreads**2).sum(axis=1)),
            np.exp(_NOISE_STD * np.clip(shared[:, 5], -_MOST_NOISE_STDS, _MOST_NOISE_STDS)),
            _DRIFT * np.exp(_DRIFT_STD * shared[:, 6]),
            each,
        )

    def _made(self, shared: FloatArray, own: FloatArray) -> Population:
        """Return a population of coordinates."""
        shapes, spans_s = self.shapes_of(shared), self.spans_of(shared)
        parts = []
        for release in range(own.shape[1]):
            place, rate = self.places_of(own[:, release]), self.rates_of(own[:, release])
            ways_m = self.ways_of(own[:, release], shared)
            mean, spread = self._readings.of(place, shapes, spans_s, ways_m)
            parts.append((rate[:, None] * mean, rate[:, None] * spread))
        size = (len(shared), own.shape[1], self._backgrounds.readings)
        means = np.array([mean for mean, _ in parts]).swapaxes(0, 1) if parts else np.zeros(size)
        spreads = np.array([one for _, one in parts]).swapaxes(0, 1) if parts else np.zeros(size)
        logs, backgrounds = self._log_likelihoods(shared, means, spreads)
        return Population(
            shared=shared, own=own, means=means, spreads=spreads, logs=logs,
            backgrounds=backgrounds,
        )  # fmt: skip

    def _resampled(self, weights: FloatArray) -> FloatArray:
        """Return the numbers of hypotheses, each as often as its weight says."""
        total = np.cumsum(weights)
        places = (np.arange(len(weights)) + self._generator.random()) / len(weights) * total[-1]
        return np.minimum(np.searchsorted(total, places), len(weights) - 1)

    def _move(self, now: Population, power: float) -> None:
        """Move all hypotheses at a power of the likelihood."""
        others = (now.shared.copy(), now.own.copy())
        releases = range(now.own.shape[1])
        for _ in range(self._options.sweeps):
            self._try(now, others, power, releases)
            for release in releases:
                self._try(now, others, power, range(release, release + 1))

    def _try(
        self,
        now: Population,
        others: tuple[FloatArray, FloatArray],
        power: float,
        changed: range,
    ) -> None:
        """Move some shared coordinates and those of some releases by a difference of two others.

        Each hypothesis moves all its coordinates of these, or about a third (crossover).
        """
        generator, count = self._generator, len(now.logs)
        first, second = generator.integers(count, size=(2, count))
        size = SHARED + OWN * len(changed)
        kept = generator.random((count, size)) < generator.choice([0.3, 1.0], count)[:, None]
        scale = (
            2.38
            / np.sqrt(2.0 * np.maximum(kept.sum(axis=1), 1))
            * 10.0 ** (generator.uniform(-0.7, 0.1, count))
        )
        kept[:, KIND] = False
        # The whole difference leads from one mode to another.
        scale[generator.random(count) < 0.1] = 1.0
        shared, own = now.shared.copy(), now.own.copy()
        step = scale[:, None] * kept
        jitter = 1e-3 * generator.standard_normal((count, size)) * kept
        shared += step[:, :SHARED] * (others[0][first] - others[0][second]) + jitter[:, :SHARED]
        for number, release in enumerate(changed):
            part = slice(SHARED + OWN * number, SHARED + OWN * (number + 1))
            difference = others[1][first, release] - others[1][second, release]
            own[:, release] += step[:, part] * difference + jitter[:, part]
        inside = ((own > 0.0) & (own < 1.0)).all(axis=(1, 2))
        own = np.clip(own, 0.0, 1.0)
        tried = self._made(shared, own)
        gained = power * (tried.logs - now.logs)
        gained -= 0.5 * ((shared**2).sum(axis=1) - (now.shared**2).sum(axis=1))
        taken = inside & (np.log(generator.random(count)) < gained)
        now.accept(tried, taken)


def _student_quantile(shares: FloatArray) -> FloatArray:
    """Return the quantiles of Student's t of four degrees of freedom, in its closed form.

    A wind direction that is about right errs by it.
    """
    root = np.sqrt(4.0 * shares * (1.0 - shares))
    above = np.maximum(np.cos(np.arccos(root) / 3.0) / root - 1.0, 0.0)
    return np.asarray(np.sign(shares - 0.5) * 2.0 * np.sqrt(above))


def _next_step(logs: FloatArray, most: float) -> float:
    """Return the step of the power that leaves `_ESS_SHARE` of the hypotheses their weight."""

    def left(step: float) -> float:
        weights = np.exp(step * (logs - logs.max()))
        return float(weights.sum() ** 2 / (weights**2).sum() / len(logs)) - _ESS_SHARE

    if left(most) >= 0.0:
        return most
    found: Callable[..., float] = optimize.brentq
    return float(found(left, 0.0, most))
