# SPDX-License-Identifier: Apache-2.0
"""Windows of a gas sensor: readings from the gas along a flight."""

import math
import zlib
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.detection.gas_sensor import GasSensor, Intake
from rocsafe_geo.limits import require_between
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_geo.wind.gusts import correlated_noise

Place = tuple[float, float, float]
# A gap between samples beyond which the past of the sensor is unknown, seconds.
LARGEST_GAP_S = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class GasSample:
    """A moment of a flight.

    Attributes
    ----------
    time_ns
        Time of the moment, nanoseconds.
    value
        What the sensor would read in the long run in the air beside the vehicle, in its unit.
    believed
        Where the vehicle believes it is: latitude and longitude in degrees, altitude in metres;
        NaN: unknown.
    """

    time_ns: int
    value: float
    believed: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class GasMeasurement:
    """A reading at the end of a window.

    Attributes
    ----------
    time_ns
        End of the window, nanoseconds.
    window_s
        Length of the window, seconds.
    raw
        What the sensor shows, in its unit; below 0 by noise and drift.
    corrected
        The same without its delay in following, as a user would compute it; noisier.
    std
        Standard deviation of `raw`.
    is_below_limit, is_saturated
        Whether it is below the limit of detection; whether it is at its ceiling or clears down.
    bars
        Bars that it shows.
    believed
        Mean believed place within the window.
    """

    time_ns: int
    window_s: float
    raw: float
    corrected: float
    std: float
    is_below_limit: bool
    is_saturated: bool
    bars: int
    believed: Place


class WindowSensor:
    """Reads in windows that begin at whole multiples of their length since the epoch.

    A reading depends on the seed, the vehicle, the number of the window and the gas along the
    flight within the memory of the sensor before it, which starts from rest: so restarts and
    speed change no reading. A window whose past was not seen whole gives none.
    """

    def __init__(
        self, sensor: GasSensor, intake: Intake, vehicle: str, window_s: float, seed: int
    ) -> None:
        require_between('window_s', window_s, 0.05, 3600.0, 's')
        self._sensor, self._intake = sensor, intake
        self._name = zlib.crc32(f'{vehicle}/{sensor.name}'.encode())
        self._seed = seed
        self._window_s = window_s
        self._window_ns = round(window_s * NS_PER_S)
        self._past_ns = round((sensor.memory_s + intake.delay_s) * NS_PER_S) + self._window_ns
        self._samples: list[GasSample] = []
        self._next: int | None = None

    def add(self, sample: GasSample) -> GasMeasurement | None:
        """Take `sample`, later than all before, and return the reading it completes, if any."""
        if self._samples and sample.time_ns - self._samples[-1].time_ns > LARGEST_GAP_S * NS_PER_S:
            self._samples = []
            self._next = None
        self._samples.append(sample)
        ended = sample.time_ns // self._window_ns
        if self._next is None:
            self._next = ended + 1
            return None
        if ended < self._next:
            return None
        self._next = ended + 1
        reading = self._reading(ended)
        self._forget(ended * self._window_ns - self._past_ns)
        return reading

    def _reading(self, ended: int) -> GasMeasurement | None:
        """Return the reading of the window that ends at `ended` windows since the epoch."""
        end_ns = ended * self._window_ns
        if self._samples[0].time_ns > end_ns - self._past_ns:
            return None
        own = self._samples[self._first_within(end_ns - self._past_ns) :]
        values, is_saturated = self._shown(own, end_ns)
        before, now = (
            value + self._noise(number, value)
            for value, number in zip(values, (ended - 1, ended), strict=True)
        )
        top = self._sensor.ceiling
        raw = top if is_saturated else min(now, top)
        rate = (now - before) / self._window_s
        constant = self._sensor.rise_s if rate > 0.0 else self._sensor.fall_s
        return GasMeasurement(
            time_ns=end_ns,
            window_s=self._window_s,
            raw=raw,
            corrected=raw if is_saturated else now + constant * rate,
            std=self._std(values[1]),
            is_below_limit=raw < self._sensor.limit,
            is_saturated=is_saturated or raw >= top,
            bars=self._sensor.bar_count(raw),
            believed=self._believed(end_ns),
        )

    def _shown(self, samples: Sequence[GasSample], end_ns: int) -> tuple[list[float], bool]:
        """Return what it shows without noise at both ends of the window, and if it clears down."""
        first_ns = end_ns - self._past_ns
        delay_ns = self._intake.delay_s * NS_PER_S
        times = [(one.time_ns - first_ns + delay_ns) / NS_PER_S for one in samples]
        values = self._sensor.follow(times, [one.value * self._intake.dilution for one in samples])
        last_s = self._past_ns / NS_PER_S
        ends = [float(np.interp(at, times, values)) for at in (last_s - self._window_s, last_s)]
        recent = values[bisect_left(times, last_s - self._sensor.clear_down_s) :]
        return ends, bool(len(recent) and recent.max() > self._sensor.overload)

    def _std(self, value: float) -> float:
        return math.hypot(self._sensor.noise, self._sensor.relative_noise * value)

    def _noise(self, number: int, value: float) -> float:
        generator = np.random.default_rng([self._seed, self._name, number])
        drift_time = number * self._window_s / self._sensor.drift_s
        drift = correlated_noise(self._seed + self._name, drift_time)[0] * self._sensor.drift
        return float(generator.standard_normal()) * self._std(value) + float(drift)

    def _believed(self, end_ns: int) -> Place:
        recent = self._samples[self._first_within(end_ns - self._window_ns + 1) :]
        places = np.array([one.believed for one in recent if one.time_ns <= end_ns])
        places = places.reshape(-1, 3)
        known = places[np.isfinite(places).all(axis=1)]
        if not len(known):
            return (math.nan, math.nan, math.nan)
        latitude, longitude, altitude = known.mean(axis=0).tolist()
        return latitude, longitude, altitude

    def _first_within(self, time_ns: int) -> int:
        return bisect_left(self._samples, time_ns, key=lambda one: one.time_ns)

    def _forget(self, time_ns: int) -> None:
        """Drop samples before a time, but one, so that the past stays whole."""
        del self._samples[: max(self._first_within(time_ns) - 1, 0)]
