# SPDX-License-Identifier: Apache-2.0
"""Survey files of any origin: tables of readings with units in the names of their columns."""

import csv
import itertools
import math
from array import array
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.csv_rows import UTF_16_MARKS
from rocsafe_geo.storage.named_file import require_file
from rocsafe_radiation.errors import RadiationError
from rocsafe_radiation.readings.row_checks import (
    at_top,
    dead,
    far,
    from_middle_m,
    jumping,
    of_other_units,
    out_of_range,
    repeated,
)
from rocsafe_radiation.readings.survey import LocalReading

Row = Mapping[str, str]
# Columns of dose rates, and microsievert per hour for one of their units.
DOSE_RATE_COLUMNS = {
    'dose_rate_usvh': 1.0,
    'dose_rate_nsvh': 1e-3,
    'dose_rate_msvh': 1e3,
    'dose_rate_svh': 1e6,
    'dose_rate_usvps': 3600.0,
}
RATE_COLUMN, STD_COLUMN = 'dose_rate_usvh', 'dose_rate_std_usvh'
REFERENCE_COLUMN = 'reference_counts'
GEODETIC_COLUMNS = ('latitude_deg', 'longitude_deg')
LOCAL_COLUMNS = ('east_m', 'north_m')
NUMBER, PLACE, SATURATED, REPEATED = (
    'not a number where one is needed',
    'a place at 0, 0',
    'saturated: the dose rate is only a lower limit',
    'the same stamp of the same vehicle again',
)
# What tells the detectors of a file apart.
OWNERS = ('vehicle', 'instrument', 'detector')
HEADER, FIELDS, FAR, DEAD, UNIT, TOP, AGAIN = (
    'the names of the columns again',
    'more fields than columns: decimal commas need another separator, ; or a tabulator, or quotes',
    'farther than 1 km, and 20 times as far as half of all, from the middle of the others',
    'of a detector that counted nothing: dead, no proof of absence',
    'counts and dose rate that do not agree as in the others: another unit',
    'the largest that the detector shows: saturated',
    'as the one before: the detector is read too often, or stuck',
)
# So many dose rates among those of another size are no accident.
FEWEST_JUMPS, MOST_LINES_NAMED, LONGEST_SHOWN = 5, 5, 60
SEPARATORS = ';\t,'
# Lines above the names of the columns begin so: comments, and what Excel writes.
NO_NAMES = ('#', 'sep=')
ENCODINGS = ('utf-8-sig', 'cp1252')


class ReadingsFileError(RadiationError):
    """A file is not a table of readings."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadingsFile:
    """Content of a survey file.

    Attributes
    ----------
    observations
        Valid readings, places in the frame below.
    frame
        Of their places; None if the file itself is in metres.
    dropped
        Lines of the rows left out, by reason; the first line of a file is 1.
    backward_steps
        Number of times that the clock of a vehicle went backwards; such rows are kept.
    models
        Names of field models that the rows state.
    reference_counts
        Counts of each reading in a window above the lines of the source; empty if the file has
        none.
    is_ground_guessed
        Whether the lowest altitude is taken for that of the ground.
    """

    observations: tuple[LocalReading, ...]
    frame: LocalFrame | None
    dropped: Mapping[str, tuple[int, ...]]
    backward_steps: int
    models: frozenset[str]
    reference_counts: tuple[float, ...] = ()
    is_ground_guessed: bool = False


@dataclass(frozen=True, slots=True)
class _Columns:
    """Which columns a file has."""

    place: tuple[str, str]
    up: str
    dose_rate: str
    has_counts: bool
    has_reference: bool
    has_saturated: bool
    names: tuple[str, ...]


def read_readings(
    path: Path, height_m: float = math.nan, ground_altitude_m: float = math.nan
) -> ReadingsFile:
    """Read a CSV file with a row of column names.

    Columns: ``latitude_deg``, ``longitude_deg``, ``altitude_m`` or ``east_m``, ``north_m``,
    ``up_m``; one of ``dose_rate_usvh``, ``_nsvh``, ``_msvh``, ``_svh``, ``_usvps``, or ``counts``
    and ``live_time_s``, or both; optional ``dose_rate_std_usvh``, ``time_ns``, ``vehicle``,
    ``instrument`` or ``detector`` (each has a sensitivity of its own), ``model``, ``saturated``
    (1: only a lower limit, left out), and ``reference_counts`` of a window of the spectrum above
    the lines of the source, which predict the background. Others are ignored. Rows without a valid
    place and value are left out, and their lines are kept by reason. Columns may be separated by
    semicolons or tabulators, with decimal commas; the text may be UTF-8, UTF-16 with its mark, or
    that of Windows.

    Parameters
    ----------
    path
        The file.
    height_m
        Height above the ground of all readings of a file without altitudes, metres.
    ground_altitude_m
        Altitude of the ground, in the datum of the file; NaN: the lowest altitude of the file.

    Raises
    ------
    ReadingsFileError
        In one line that says what is missing or double.
    """
    try:
        require_file(path)
        with path.open(encoding=_encoding(path), newline='') as stream:
            head, above = stream.readline(), 1
            while head and (not head.strip() or head.startswith(NO_NAMES)):
                head, above = stream.readline(), above + 1
            separator = max(SEPARATORS, key=head.count)
            names = next(csv.reader([head], delimiter=separator), [])
            table = csv.DictReader(stream, [name.strip() for name in names], delimiter=separator)
            columns = _columns(path, table.fieldnames or (), height_m)
            rows = _Rows(columns, height_m)
            for row in table:
                rows.add(row, table.line_num + above)
    except OSError as error:
        raise ReadingsFileError(f'{path}: cannot be read: {error.strerror}') from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ReadingsFileError(f'{path}: cannot be read: {error}') from error
    return _checked(path, rows, ground_altitude_m)


def _encoding(path: Path) -> str:
    """Return the first encoding that all of a file can be read in."""
    with path.open('rb') as stream:
        if stream.read(2) in UTF_16_MARKS:
            return 'utf-16'
    for name in ENCODINGS[:-1]:
        try:
            with path.open(encoding=name) as text:
                for _ in text:
                    pass
        except UnicodeDecodeError:
            continue
        return name
    return ENCODINGS[-1]


def _columns(path: Path, names: Sequence[str], height_m: float) -> _Columns:
    known = set(names)
    double = sorted(name for name in known if name and names.count(name) > 1)
    if double:
        raise ReadingsFileError(f'{path}: has the column {double[0]} more than once: keep one')
    place = next(
        (pair for pair in (GEODETIC_COLUMNS, LOCAL_COLUMNS) if known.issuperset(pair)), None
    )
    if place is None:
        raise ReadingsFileError(
            f'{path}: has no columns latitude_deg and longitude_deg, nor east_m and north_m, in '
            f'its first line: {", ".join(names)[:LONGEST_SHOWN]!r}'
        )
    up = 'altitude_m' if place == GEODETIC_COLUMNS else 'up_m'
    if up not in known and not math.isfinite(height_m):
        raise ReadingsFileError(f'{path}: has no column {up}; give the height of the readings')
    rates = sorted(known.intersection(DOSE_RATE_COLUMNS))
    if len(rates) > 1:
        raise ReadingsFileError(
            f'{path}: has dose rates in several units, {" and ".join(rates)}: keep one'
        )
    has_counts = {'counts', 'live_time_s'} <= known
    if not rates and not has_counts:
        raise ReadingsFileError(
            f'{path}: has no column dose_rate_usvh, nor counts and live_time_s'
        )
    wanted = (*place, up, *rates, STD_COLUMN, REFERENCE_COLUMN)
    if has_counts:
        wanted += ('counts', 'live_time_s')
    return _Columns(
        names=tuple(name for name in wanted if name in known),
        place=place,
        up=up if up in known else '',
        dose_rate=rates[0] if rates else '',
        has_counts=has_counts,
        has_reference=REFERENCE_COLUMN in known,
        has_saturated='saturated' in known,
    )


class _Rows:
    """Rows kept so far, and the lines of those left out."""

    def __init__(self, columns: _Columns, height_m: float) -> None:
        self.columns, self._height_m = columns, height_m
        # Flat: a million rows as tuples take 0.4 GB.
        self._values = array('d')
        self.lines: list[int] = []
        self.vehicles: list[str] = []
        self.times_s = array('d')
        self.models: set[str] = set()
        self.dropped: dict[str, list[int]] = defaultdict(list)
        self.backward_steps = 0
        self._latest: dict[str, float] = {}
        self._seen: dict[str, set[str]] = defaultdict(set)

    def add(self, row: Row, line: int) -> None:
        """Keep a row or its reason to be left out."""
        stamp = (row.get('time_ns') or '').strip()
        vehicle = ' '.join(filter(None, ((row.get(one) or '').strip() for one in OWNERS)))
        values = _values(row, self.columns, self._height_m)
        reason = values if isinstance(values, str) else ''
        seen = self._seen[vehicle]
        if not reason and stamp and stamp in seen:
            reason = REPEATED
        if not reason and _number(row.get('saturated')) > 0.0:
            reason = SATURATED
        if isinstance(values, str) or reason:
            if any('\n' in str(field) for field in row.values()):
                raise csv.Error(f'a quotation mark before line {line} is not closed')
            self.dropped[reason].append(line)
            return
        seen.add(stamp)
        time, latest = _number(stamp), self._latest.get(vehicle, -math.inf)
        self.backward_steps += time < latest
        self._latest[vehicle] = time if math.isfinite(time) else latest
        self.models.add((row.get('model') or '').strip())
        self._values.extend(values)
        self.lines.append(line)
        self.vehicles.append(vehicle)
        self.times_s.append(time / 1e9)

    def table(self) -> FloatArray:
        """Return the rows, shape (n, 8), as `_values` gives them."""
        return np.array(self._values, np.float64).reshape(-1, 8)

    def named(self, are: BoolArray) -> str:
        """Return the first lines of some of the rows, in words."""
        lines = np.array(self.lines)[are]
        named = ', '.join(map(str, lines[:MOST_LINES_NAMED].tolist()))
        return named + (' and more' if len(lines) > MOST_LINES_NAMED else '')


def _checked(path: Path, rows: _Rows, ground_altitude_m: float) -> ReadingsFile:
    """Return the readings of the rows that agree with the others."""
    table, columns = rows.table(), rows.columns
    is_geodetic = columns.place == GEODETIC_COLUMNS
    rates, counts, live_s = table[:, 3], table[:, 5], table[:, 6]
    if not columns.has_counts:
        jumps = jumping(rows.vehicles, rates)
        if jumps.sum() >= FEWEST_JUMPS:
            raise ReadingsFileError(
                f'{path}: {jumps.sum()} dose rates are 300 times those beside them or a 300th '
                f'(lines {rows.named(jumps)}): several units in one column'
            )
    kept = np.ones(len(table), dtype=bool)
    known = np.nan_to_num(rates)
    amounts = np.where(live_s > 0.0, counts / live_s, known)
    for reason, are_wrong in (
        (FAR, far(table[:, :2], is_geodetic)),
        (DEAD, dead(rows.vehicles, counts + known)),
        (UNIT, of_other_units(rows.vehicles, counts, live_s, rates)),
        (TOP, at_top(rows.vehicles, amounts) & (not columns.has_saturated)),
        (AGAIN, repeated(rows.vehicles, counts, known, from_middle_m(table[:, :2], is_geodetic))),
    ):
        if (are_wrong & kept).any():
            rows.dropped[reason] += [rows.lines[k] for k in np.flatnonzero(are_wrong & kept)]
        kept &= ~are_wrong
    table, times_s = table[kept], np.array(rows.times_s)[kept]
    vehicles = list(itertools.compress(rows.vehicles, kept))
    if not columns.up:
        ground_altitude_m = 0.0
    frame = _frame(table, ground_altitude_m) if is_geodetic and len(table) else None
    return ReadingsFile(
        observations=_observations(table, frame, vehicles, times_s),
        frame=frame,
        dropped={reason: tuple(lines) for reason, lines in rows.dropped.items()},
        backward_steps=rows.backward_steps,
        models=frozenset(rows.models - {''}),
        reference_counts=tuple(table[:, 7].tolist()) if columns.has_reference else (),
        is_ground_guessed=frame is not None and not math.isfinite(ground_altitude_m),
    )


def _values(row: Row, columns: _Columns, height_m: float) -> tuple[float, ...] | str:
    """Return place, dose rate, its standard deviation, counts and live time, or a reason."""
    if None in row:
        return FIELDS
    first, second = columns.place
    if (row.get(first) or '').strip() == first:
        return HEADER
    known = {name: _number(row.get(name)) for name in columns.names}
    if columns.dose_rate:
        known[RATE_COLUMN] = known[columns.dose_rate] * DOSE_RATE_COLUMNS[columns.dose_rate]
    up = known[columns.up] if columns.up else height_m
    rate = known.get(RATE_COLUMN, math.nan)
    counts, live_s = known.get('counts', math.nan), known.get('live_time_s', math.nan)
    reference = known.get(REFERENCE_COLUMN, 0.0)
    counted = math.isfinite(counts) and math.isfinite(live_s)
    if not all(map(math.isfinite, (known[first], known[second], up, reference))) or not (
        math.isfinite(rate) or counted
    ):
        return NUMBER
    if first == GEODETIC_COLUMNS[0] and known[first] == known[second] == 0.0:
        return PLACE
    reason = out_of_range(known)
    if reason:
        return reason
    std = known.get(STD_COLUMN, math.nan)
    return (
        known[first],
        known[second],
        up,
        rate,
        std,
        counts if counted else 0.0,
        live_s if counted else math.nan,
        reference,
    )


def _number(text: str | None) -> float:
    try:
        # Columns are separated already: a comma that is left is a decimal one.
        value = float((text or 'nan').replace(',', '.'))
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def _frame(array: FloatArray, ground_altitude_m: float) -> LocalFrame:
    """Return a frame about the middle of all readings, at the ground or the lowest of them."""
    is_known = math.isfinite(ground_altitude_m)
    return LocalFrame(
        GeoPosition(
            latitude_deg=float(np.median(array[:, 0])),
            longitude_deg=float(np.median(array[:, 1])),
            altitude_m=ground_altitude_m if is_known else float(array[:, 2].min()),
        )
    )


def _observations(
    array: FloatArray, frame: LocalFrame | None, vehicles: Sequence[str], times_s: FloatArray
) -> tuple[LocalReading, ...]:
    places = frame.to_enu(*array[:, :3].T) if frame else array[:, :3]
    return tuple(
        LocalReading(
            position_enu_m=(float(east), float(north), float(up)),
            dose_rate_usvh=row[3],
            dose_rate_std_usvh=row[4],
            counts=row[5],
            live_time_s=row[6],
            vehicle=vehicle,
            time_s=time_s,
        )
        for (east, north, up), row, vehicle, time_s in zip(
            places, array.tolist(), vehicles, times_s.tolist(), strict=True
        )
    )
