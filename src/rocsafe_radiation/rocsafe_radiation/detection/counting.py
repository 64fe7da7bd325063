# SPDX-License-Identifier: Apache-2.0
"""Windows of a counting detector: measurements from samples of the field along a flight."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_radiation.detection.detector import (
    DetectorModel,
    Measurement,
    measure,
    window_generator,
)

Place = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """A moment of a flight; places are latitude and longitude in degrees, altitude in metres.

    Attributes
    ----------
    time_ns
        Time of the moment, nanoseconds.
    place
        Where the detector is.
    believed
        Where the vehicle believes it is; NaN: unknown.
    """

    time_ns: int
    place: Place
    believed: Place


@dataclass(frozen=True, slots=True, kw_only=True)
class WindowReading:
    """A measurement, the end of its window and the mean believed place within."""

    time_ns: int
    measurement: Measurement
    latitude_deg: float
    longitude_deg: float
    altitude_m: float


# Dose rate of Cs-137 that gives as many counts as the field, at n samples, uSv/h, shape (n,).
DoseRates = Callable[[Sequence[Sample]], FloatArray]


class WindowCounter:
    """Counts in windows that begin at whole multiples of their length since the epoch.

    The counts of a window depend on the seed, the vehicle, the number of the window and the field
    along it, so restarts and speed change nothing; a window of which only a part was seen, as
    after a restart, gives no reading. A window is complete with a sample at its end or, without
    one, with the first sample after it. The field is evaluated once for all samples of a window.
    """

    def __init__(
        self,
        detector: DetectorModel,
        vehicle: str,
        window_s: float,
        seed: int,
        dose_rates: DoseRates,
    ) -> None:
        if not 1e-3 <= window_s <= 3600.0:
            raise ValueError(f'window_s = {window_s} must be within 0.001 and 3600')
        self._detector = detector
        self._vehicle = vehicle
        self._seed = seed
        self._dose_rates = dose_rates
        self._window_ns = round(window_s * NS_PER_S)
        self._samples: list[Sample] = []
        self._index: int | None = None
        self._is_whole = False

    def add(self, sample: Sample) -> WindowReading | None:
        """Take `sample`, later than all before, and return the window it completes, if any."""
        # The end of a window belongs to it, its beginning does not.
        index = (sample.time_ns - 1) // self._window_ns
        if index == self._index:
            self._samples.append(sample)
            return self._closed() if self._is_end(sample) else None
        reading = self._closed()
        self._is_whole = self._index is not None and index == self._index + 1
        self._index = index
        self._samples = [sample]
        if reading is None and self._is_end(sample):
            return self._closed()
        return reading

    def _is_end(self, sample: Sample) -> bool:
        return sample.time_ns % self._window_ns == 0

    def _closed(self) -> WindowReading | None:
        """Return the reading of the current window, once, if all of it was seen."""
        samples, self._samples = self._samples, []
        if not samples or not self._is_whole or self._index is None:
            return None
        generator = window_generator(self._seed, self._vehicle, self._index)
        mean_usvh = math.fsum(self._dose_rates(samples).tolist()) / len(samples)
        window_s = self._window_ns / NS_PER_S
        places = np.array([sample.believed for sample in samples])
        known = places[np.isfinite(places).all(axis=1)]
        latitude, longitude, altitude = known.mean(axis=0) if len(known) else [math.nan] * 3
        return WindowReading(
            time_ns=(self._index + 1) * self._window_ns,
            measurement=measure(self._detector, mean_usvh, window_s, generator),
            latitude_deg=float(latitude),
            longitude_deg=float(longitude),
            altitude_m=float(altitude),
        )
