# SPDX-License-Identifier: Apache-2.0
"""A particle counter that tells fluorescent particles, and its trigger.

The trigger asks how improbable the count of fluorescent particles is, given the windows before:
natural background changes by orders of magnitude, so a level alone means nothing.
"""

import math
import zlib
from collections import deque
from dataclasses import dataclass

import numpy as np
from scipy import special

from rocsafe_geo.limits import require_between, require_count, require_positive
from rocsafe_geo.wind.gusts import correlated_noise


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticleCounter:
    """A kind of particle counter; figures of its class (reference/dispersion.md, section 2).

    Attributes
    ----------
    flow_l_min
        Air that it draws, litres a minute.
    efficiency
        Share of the particles that it counts.
    background_per_l
        Natural particles in a litre, and the share of them that fluoresces.
    fluorescent_share
        See `background_per_l`.
    background_scatter, background_s
        Standard deviation of the logarithm of the background, and time in which it changes, s.
    dead_time_s
        Time for which it is blind after each particle, seconds.
    baseline_windows
        Windows that the trigger compares with.
    false_alarm_probability
        Probability of a trigger in a window of background that does not change.
    """

    flow_l_min: float = 1.0
    efficiency: float = 0.7
    background_per_l: float = 10_000.0
    fluorescent_share: float = 0.01
    background_scatter: float = 0.1
    background_s: float = 600.0
    dead_time_s: float = 2e-6
    baseline_windows: int = 30
    false_alarm_probability: float = 1e-4

    def __post_init__(self) -> None:
        for name in ('flow_l_min', 'background_per_l', 'background_s'):
            require_positive(name, getattr(self, name))
        for name in ('efficiency', 'fluorescent_share', 'background_scatter'):
            require_between(name, getattr(self, name), 0.0, 1.0)
        require_between('false_alarm_probability', self.false_alarm_probability, 1e-12, 0.5)
        require_between('dead_time_s', self.dead_time_s, 0.0, 0.01, 's')
        require_count('baseline_windows', self.baseline_windows, 2, 10_000)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticleCount:
    """Counts of one window.

    Attributes
    ----------
    total, fluorescent
        Particles counted.
    particles_per_l
        Concentration that the total means, 1/l.
    p_value
        Probability of so many fluorescent particles or more without a release, NaN while there
        is nothing to compare with.
    is_triggered
        Whether `p_value` is below the probability of a false alarm.
    is_saturated
        Whether the counter was blind for more than 0.3 of the time.
    """

    total: int
    fluorescent: int
    particles_per_l: float
    p_value: float
    is_triggered: bool
    is_saturated: bool


class CountingWindows:
    """Counts window after window; a count depends on seed, vehicle, window and particles alone."""

    def __init__(self, counter: ParticleCounter, vehicle: str, window_s: float, seed: int) -> None:
        self._counter = counter
        self._name = zlib.crc32(f'{vehicle}/particles'.encode())
        self._window_s = require_between('window_s', window_s, 0.1, 600.0, 's')
        self._seed = seed
        self._last: int | None = None
        self._baseline: deque[tuple[int, int]] = deque(maxlen=counter.baseline_windows)

    def count(self, window: int, released_per_l: float) -> ParticleCount:
        """Return the counts of a window.

        Parameters
        ----------
        window
            Its number since the epoch; after a gap the trigger begins again.
        released_per_l
            Mean concentration of released, fluorescent particles, 1/l.
        """
        if self._last is not None and window != self._last + 1:
            self._baseline.clear()
        self._last = window
        fluorescent, total, is_saturated = self._drawn(window, released_per_l)
        p_value = self._p_value(fluorescent, total)
        self._baseline.append((fluorescent, total))
        litres = self._counter.flow_l_min / 60.0 * self._window_s * self._counter.efficiency
        return ParticleCount(
            total=total,
            fluorescent=fluorescent,
            particles_per_l=total / litres,
            p_value=p_value,
            is_triggered=p_value < self._counter.false_alarm_probability,
            is_saturated=is_saturated,
        )

    def _drawn(self, window: int, released_per_l: float) -> tuple[int, int, bool]:
        counter = self._counter
        time = window * self._window_s / counter.background_s
        change = float(correlated_noise(self._seed + self._name, time)[0])
        natural = counter.background_per_l * math.exp(counter.background_scatter * change)
        per_s = counter.flow_l_min / 60.0 * counter.efficiency
        rate = (natural + released_per_l) * per_s
        live = 1.0 / (1.0 + rate * counter.dead_time_s)
        generator = np.random.default_rng([self._seed, self._name, window])
        glowing = natural * counter.fluorescent_share + released_per_l
        seen = per_s * live * self._window_s
        fluorescent = int(generator.poisson(glowing * seen))
        plain = int(generator.poisson(natural * (1.0 - counter.fluorescent_share) * seen))
        return fluorescent, fluorescent + plain, 1.0 - live > 0.3

    def _p_value(self, fluorescent: int, total: int) -> float:
        """Return how probable so many fluorescent particles are, given the windows before.

        Given their sum, counts of the same rate share it by a binomial law (Przyborowski and
        Wilenski 1940); the number of other particles tells how much air was drawn and how the
        natural background changed.
        """
        if len(self._baseline) < self._counter.baseline_windows:
            return math.nan
        before, all_before = np.sum(self._baseline, axis=0).tolist()
        plain, plain_before = total - fluorescent, all_before - before
        if plain + plain_before == 0:
            return math.nan
        share = plain / (plain + plain_before)
        return float(special.bdtrc(fluorescent - 1, fluorescent + before, share))
