# SPDX-License-Identifier: Apache-2.0
"""Readings as the localiser needs them: places, counts, and counts for a dose rate."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_radiation.readings.calibration import calibration_of
from rocsafe_radiation.readings.flight import Flight, flight_of
from rocsafe_radiation.readings.ground import LEVEL, Ground
from rocsafe_radiation.readings.row_checks import rows_by_vehicle

# A reading without statistics counts as that of a large scintillator: errors of position and model
# limit it then, not counts.
NOMINAL_COUNTS_PER_USVH = 550.0 * 0.2
SMALLEST_STD_SHARE = 0.002
# Cells of too many readings grow by this factor.
CELL_GROWTH = 1.25


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalReading:
    """A reading in the local frame, of any detector.

    Attributes
    ----------
    position_enu_m
        East, north, up in metres.
    dose_rate_usvh
        Dose rate; NaN: there are counts only.
    dose_rate_std_usvh
        Its standard deviation; 0 or NaN: unknown.
    counts
        Raw counts; 0 if the detector does not count.
    live_time_s
        Live time, seconds; NaN if the detector does not count.
    vehicle, time_s
        Whose reading it is, and its time, seconds since any moment; NaN if it is not known.
    """

    position_enu_m: tuple[float, float, float]
    dose_rate_usvh: float
    dose_rate_std_usvh: float = 0.0
    counts: float = 0.0
    live_time_s: float = math.nan
    vehicle: str = ''
    time_s: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class RadiationSurvey:
    """Readings of a survey.

    Attributes
    ----------
    positions_enu_m
        Shape (n, 3).
    counts
        Counts of each reading, or the number with the same relative error, shape (n,).
    exposures
        Expected counts for one microsievert per hour, shape (n,).
    dark_counts
        Expected counts without any radiation, shape (n,), or (1,): the same for all.
    background_shape
        The background at each reading relative to its mean, as known from other data, for instance
        a window of the spectrum above the source's lines, shape (n,); None: constant.
    ground
        Ground below the readings.
    caveats
        Why these readings prove nothing, in words: a ground that nobody gave, a dead detector.
    flight
        When and how the readings were flown past; None: not known.
    is_nominal
        Whether all readings are dose rates alone, whose noise is not told: counts and exposures
        are then right up to a common factor.
    """

    positions_enu_m: FloatArray
    counts: FloatArray
    exposures: FloatArray
    dark_counts: FloatArray = field(default_factory=lambda: np.zeros(1))
    flight: Flight | None = None
    is_nominal: bool = False
    background_shape: FloatArray | None = None
    ground: Ground = LEVEL
    caveats: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        size = len(self.counts)
        shape = self.background_shape
        if shape is not None and (shape.shape != (size,) or not (shape > 0.0).all()):
            raise ValueError('background_shape must be above 0 and as many as readings')
        if self.positions_enu_m.shape != (size, 3) or self.exposures.shape != (size,):
            raise ValueError('positions, counts and exposures of a survey must be as many')
        if not (np.isfinite(self.positions_enu_m).all() and np.isfinite(self.counts).all()):
            raise ValueError('positions and counts of a survey must be finite')
        if not (self.counts >= 0).all() or not (self.exposures > 0).all():
            raise ValueError('counts must be at least 0, exposures above 0')
        if self.dark_counts.shape not in ((1,), (size,)) or not (self.dark_counts >= 0.0).all():
            raise ValueError('dark_counts must be at least 0 and as many as readings')

    @property
    def size(self) -> int:
        """Number of readings."""
        return len(self.counts)

    @property
    def net_counts(self) -> FloatArray:
        """Counts less those expected without radiation, shape (n,)."""
        return self.counts - self.dark_counts

    @property
    def heights_m(self) -> FloatArray:
        """Height of each reading above the ground below it, shape (n,)."""
        ups = self.positions_enu_m[:, 2]
        if self.ground.is_level:
            return ups
        return np.asarray(ups - self.ground.ups_at(self.positions_enu_m[:, :2]))

    def height_m(self, source_height_m: float) -> float:
        """Return the median height of the readings above sources, at least 1 m."""
        return max(1.0, float(np.median(self.heights_m)) - source_height_m)

    def only(self, rows: IndexArray) -> 'RadiationSurvey':
        """Return the survey of some readings, by their numbers."""
        shape, dark, flight = self.background_shape, self.dark_counts, self.flight
        return replace(
            self,
            positions_enu_m=self.positions_enu_m[rows],
            counts=self.counts[rows],
            exposures=self.exposures[rows],
            dark_counts=dark if len(dark) == 1 else dark[rows],
            background_shape=None if shape is None else shape[rows],
            flight=None if flight is None else flight.only(rows),
        )

    def merged(self, cell_m: float, most: int) -> 'RadiationSurvey':
        """Return a survey with one reading for each cube of `cell_m`, at the mean place within.

        Counts and exposures add up. With cells much smaller than the height above the source, the
        result of a fit is the same. Each leg has cells of its own. Where there are more than
        `most` cells, the flight is forgotten: of so many readings, errors average out; then cells
        are larger.
        """
        found = self._merged(cell_m)
        if found.size > most and self.flight is not None:
            return replace(self, flight=None).merged(cell_m, most)
        while found.size > most:
            cell_m *= CELL_GROWTH
            found = found._merged(cell_m)
        return found

    def _merged(self, cell_m: float) -> 'RadiationSurvey':
        cells = np.floor(self.positions_enu_m / cell_m).astype(np.int64)
        cells -= cells.min(axis=0)
        _, rows, levels = (cells.max(axis=0) + 1).tolist()
        numbers = (cells[:, 0] * rows + cells[:, 1]) * levels + cells[:, 2]
        flight = self.flight
        if flight is not None:
            numbers = numbers * (int(flight.legs.max()) + 1) + flight.legs[:, 0]
        _, first, owner = np.unique(numbers, return_index=True, return_inverse=True)
        exposures = np.asarray(np.bincount(owner, self.exposures), np.float64)
        places = [
            np.bincount(owner, self.exposures * axis) / exposures
            for axis in self.positions_enu_m.T
        ]
        dark = np.broadcast_to(self.dark_counts, self.size)
        shape = self.background_shape
        if shape is not None:
            shape = np.bincount(owner, self.exposures * shape) / exposures
        return RadiationSurvey(
            background_shape=shape,
            ground=self.ground,
            caveats=self.caveats,
            is_nominal=self.is_nominal,
            positions_enu_m=np.stack(places, axis=1),
            counts=np.asarray(np.bincount(owner, self.counts), np.float64),
            dark_counts=np.asarray(np.bincount(owner, dark), np.float64),
            exposures=exposures,
            flight=None if flight is None else flight.merged(owner, first, self.exposures),
        )


def survey_of(
    observations: Sequence[LocalReading], sensitivity_cps_per_usvh: float = 0.0
) -> RadiationSurvey:
    """Return the survey of `observations`.

    Counts are used where there are any and the sensitivity of the detector is known: as given, or
    else from counts and dose rates of its vehicle, which tell its dark counts, too. A dose rate
    with a standard deviation stands for the number of counts with the same relative error. A dose
    rate alone counts as that of a large scintillator over 0.2 s.
    """
    size = len(observations)
    vehicles = [one.vehicle for one in observations]
    rates = np.array([one.dose_rate_usvh for one in observations], np.float64)
    stds = np.array([one.dose_rate_std_usvh for one in observations], np.float64)
    counts = np.array([one.counts for one in observations], np.float64)
    live_s = np.array([one.live_time_s for one in observations], np.float64)
    times_s = np.array([one.time_s for one in observations], np.float64)
    places = np.array([one.position_enu_m for one in observations], np.float64).reshape(size, 3)
    values: FloatArray = np.empty((3, size))
    for own in rows_by_vehicle(vehicles):
        values[:, own] = _counted(
            rates[own], stds[own], counts[own], live_s[own], sensitivity_cps_per_usvh
        )
    return RadiationSurvey(
        positions_enu_m=places,
        counts=values[0],
        exposures=values[1],
        dark_counts=values[2],
        is_nominal=bool((values[1] == NOMINAL_COUNTS_PER_USVH).all()),
        flight=flight_of(vehicles, times_s, places),
    )


def _counted(
    rates: FloatArray,
    stds: FloatArray,
    counts: FloatArray,
    live_s: FloatArray,
    sensitivity: float,
) -> FloatArray:
    """Return counts, exposures and dark counts of the readings of one detector, (3, n)."""
    with np.errstate(divide='ignore', invalid='ignore'):
        known = calibration_of(counts, live_s, rates)
        dark = known.dark_rate_cps * np.nan_to_num(live_s)
        exposures = (sensitivity or known.sensitivity_cps_per_usvh) * live_s
        if not sensitivity:
            # Dose rates may allow for what a live time does not tell, or come from elsewhere.
            other = (rates > 0.0) & ~known.agrees(counts, live_s, rates)
            exposures = np.where(other, np.maximum(counts - dark, 0.0) / rates, exposures)
        # Without a count, the standard deviation is that of one.
        lone = (stds > 0.0) & ~((exposures > 0.0) | (rates > 0.0))
        exposures = np.where(lone, 1.0 / stds, exposures)
        values = np.stack([np.where(lone, 0.0, counts), exposures, dark])
        told = np.where(stds > 0.0, rates / np.maximum(stds, SMALLEST_STD_SHARE * rates), 0.0) ** 2
        nominal = np.where(told > 0.0, told / rates, NOMINAL_COUNTS_PER_USVH)
    doses = np.stack([np.maximum(rates, 0.0) * nominal, nominal, np.zeros_like(rates)])
    return np.asarray(np.where(values[1] > 0.0, values, doses))
