# SPDX-License-Identifier: Apache-2.0
"""Wind from the record of an anemometer: a CSV file whose header names the convention.

Columns: ``time_s`` and either ``wind_towards_east_mps`` and ``wind_towards_north_mps``, or
``wind_speed_mps`` and ``wind_from_deg`` (where it comes from, clockwise from north). Other
columns are not read, nor rows without a time or a wind; a column ``direction`` or
``wind_direction`` is refused, as nobody knows whether it is where the wind comes from or goes to.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.storage.csv_rows import Row, column, has_all, number_in, read_table
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.wind_field import towards
from rocsafe_geo.wind.wind_vector import WindVector, wind_from

VECTOR = ('wind_towards_east_mps', 'wind_towards_north_mps')
FROM = ('wind_speed_mps', 'wind_from_deg')
WIND = {True: VECTOR, False: FROM}
AMBIGUOUS = {'direction', 'wind_direction', 'wind_direction_deg', 'wind_dir', 'wd'}
LARGEST_ROWS = 2_000_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RecordedWind:
    """Wind of a record, the same everywhere or with a profile; held before and after the record.

    Attributes
    ----------
    times_s : (n,)
        Ascending, seconds since the start of the mission.
    towards_mps : (n, 2)
        Velocity of the air towards east and north, m/s; between two times, straight.
    layer
        Profile by which the wind depends on the height, or None: it does not.
    height_m
        Height of the anemometer above the ground, metres.
    """

    times_s: FloatArray
    towards_mps: FloatArray
    layer: SurfaceLayer | None = None
    height_m: float = 10.0

    def __post_init__(self) -> None:
        if not len(self.times_s) or np.shape(self.towards_mps) != (len(self.times_s), 2):
            raise ValueError('a record of wind needs rows of a time and two components')
        if not (np.isfinite(self.times_s).all() and np.isfinite(self.towards_mps).all()):
            raise ValueError('times and components of a record of wind must be finite')
        if (np.diff(self.times_s) <= 0.0).any():
            raise ValueError('times of a record of wind must ascend')

    def wind_at(self, time_s: float) -> WindVector:
        """Return the wind at the anemometer."""
        east, north = (np.interp(time_s, self.times_s, part) for part in self.towards_mps.T)
        return WindVector(towards_east_mps=float(east), towards_north_mps=float(north))

    @property
    def strongest(self) -> WindVector:
        """The wind of the row with the highest speed."""
        row = int(np.hypot(self.towards_mps[:, 0], self.towards_mps[:, 1]).argmax())
        return self.wind_at(float(self.times_s[row]))

    def velocities_mps(self, time_s: float, places_m: FloatArray) -> FloatArray:
        """Return the velocity of the air, see `WindField`."""
        shares: FloatArray = np.ones(len(places_m))
        if self.layer is not None:
            own = float(self.layer.speed_mps(self.height_m))
            shares = self.layer.speed_mps(places_m[:, 2]) / own
        return towards(self.wind_at(time_s), shares)


def read_wind(
    path: Path, layer: SurfaceLayer | None = None, height_m: float = 10.0
) -> RecordedWind:
    """Return the wind of a record.

    Raises
    ------
    ValueError
        In one line, if the file is not there, or a column or value is missing or wrong.
    """
    return read_table(path, lambda rows: _recorded(rows, layer, height_m), LARGEST_ROWS)


def _recorded(rows: Sequence[Row], layer: SurfaceLayer | None, height_m: float) -> RecordedWind:
    is_vector = is_vector_record(set(rows[0]))
    # If no row has a wind, all stay, so that reading them names the fault of the first.
    rows = [row for row in rows if has_all(row, ('time_s', *WIND[is_vector]))] or rows
    times_s = column(rows, 'time_s')
    winds = [wind_of(row, is_vector=is_vector) for row in rows]
    return RecordedWind(
        times_s=times_s,
        towards_mps=np.array([(one.towards_east_mps, one.towards_north_mps) for one in winds]),
        layer=layer,
        height_m=height_m,
    )


def is_vector_record(names: set[str]) -> bool:
    """Return whether columns of these names hold components; else they are speed and direction.

    Raises
    ------
    ValueError
        If they hold neither, both, or a direction of unknown convention.
    """
    has = [names >= set(pair) for pair in (VECTOR, FROM)]
    if sum(has) == 1:
        return has[0]
    unclear = sorted(name for name in names if name and name.lower() in AMBIGUOUS)
    if unclear and not any(has):
        raise ValueError(
            f'column {unclear[0]} does not say whether the wind comes from there or goes there: '
            'name it wind_from_deg, or give wind_towards_east_mps and wind_towards_north_mps'
        )
    raise ValueError(
        f'needs either the columns {" and ".join(VECTOR)} or {" and ".join(FROM)}: '
        f'has {"both" if all(has) else "neither"}'
    )


def wind_of(row: Row, *, is_vector: bool) -> WindVector:
    """Return the wind of a row whose columns are as `is_vector_record` says.

    Raises
    ------
    ValueError
        If a value is not a number or out of range, with its line.
    """
    first, second = (number_in(row, name) for name in WIND[is_vector])
    try:
        if not is_vector:
            return wind_from(first, second)
        return WindVector(towards_east_mps=first, towards_north_mps=second)
    except ValueError as error:
        raise ValueError(f'line {row.line}: {error}') from error
