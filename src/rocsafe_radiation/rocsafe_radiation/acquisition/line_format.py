# SPDX-License-Identifier: Apache-2.0
"""Formats of the lines that detectors send, from a YAML file: separator, columns, units.

A file has a list ``formats``; ``tables/line_formats.yaml`` is used where no other is named.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from rocsafe_geo.storage.value_file import read_values

BUILT_IN = Path(__file__).parents[1] / 'tables' / 'line_formats.yaml'
Quantity = Literal[
    'unix_time',
    'uptime',
    'dose_rate',
    'dose_rate_std',
    'counts',
    'count_rate',
    'window',
    'live_time',
    'saturated',
    'skip',
]
_SECONDS = {'s': 1.0, 'ms': 1e-3}
_DOSE_RATES = {'nSv/h': 1e-3, 'uSv/h': 1.0, 'mSv/h': 1e3, 'Sv/h': 1e6}
# For each quantity the factor of each unit to the one used here: s, uSv/h, counts, 1/s.
UNITS: Mapping[str, Mapping[str, float]] = {
    'unix_time': _SECONDS,
    'uptime': _SECONDS,
    'dose_rate': _DOSE_RATES,
    'dose_rate_std': _DOSE_RATES,
    'counts': {'': 1.0},
    'count_rate': {'1/s': 1.0, '1/min': 1.0 / 60.0},
    'window': _SECONDS,
    'live_time': _SECONDS,
    'saturated': {'': 1.0},
}
# Values outside of these are a damaged line, not a measurement.
LARGEST: Mapping[str, float] = {
    'unix_time': 2e11,
    'uptime': 1e10,
    'dose_rate': 1e12,
    'dose_rate_std': 1e12,
    'counts': 2.0**32 - 1.0,
    'count_rate': 1e9,
    'window': 3600.0,
    'live_time': 3600.0,
    'saturated': 1.0,
}


class LineError(ValueError):
    """A line does not follow its format; the text begins with the kind of fault."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LineColumn:
    """One column: `quantity`, and `unit` as in `UNITS`."""

    quantity: Quantity
    unit: str = ''

    def __post_init__(self) -> None:
        units = UNITS.get(self.quantity)
        if units is not None and self.unit not in units:
            known = ', '.join(repr(unit) for unit in units)
            raise ValueError(f'unit of {self.quantity} is {self.unit!r}: must be one of {known}')


@dataclass(frozen=True, slots=True, kw_only=True)
class LineMeasurement:
    """What a line says.

    Attributes
    ----------
    clock_s
        Time by the clock of the detector, seconds; None: it tells none.
    dose_rate_usvh, dose_rate_std_usvh
        Ambient dose equivalent rate, and its standard deviation.
    counts
        Raw counts; 0 if it does not count.
    window_s
        Length of the window; 0: not told.
    live_time_s
        Window less dead time, as far as this is told; NaN: it does not count.
    is_saturated
        Whether the dose rate is only a lower limit.
    """

    clock_s: float | None
    dose_rate_usvh: float
    dose_rate_std_usvh: float
    counts: int
    window_s: float
    live_time_s: float
    is_saturated: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LineFormat:
    """Format of the lines of one kind of detector.

    Attributes
    ----------
    name
        Name by which it is chosen, and of the detector in its readings.
    measures
        What it measures. Gas and particles will be others.
    columns
        All columns in their order.
    separator
        Between two columns; empty: any white space.
    comment
        A line that begins with it is passed over.
    window_s
        Length of a window where no column tells it; 0: not known.
    sensitivity_cps_per_usvh
        Counts a second for each uSv/h; needed where only counts are told; 0: not known.
    dark_rate_cps
        Counts a second without radiation, which are no dose where only counts are told.
    relative_std
        Standard deviation as a share of the dose rate, where neither it nor counts are told.
    saturation_usvh
        Dose rate from which on the detector is saturated; 0: the detector tells, or never.
    """

    name: str
    columns: tuple[LineColumn, ...]
    measures: Literal['gamma_dose_rate'] = 'gamma_dose_rate'
    separator: str = ','
    comment: str = '#'
    window_s: float = 0.0
    sensitivity_cps_per_usvh: float = 0.0
    dark_rate_cps: float = 0.0
    relative_std: float = 0.0
    saturation_usvh: float = 0.0

    def __post_init__(self) -> None:
        for name in (
            'window_s', 'sensitivity_cps_per_usvh', 'dark_rate_cps', 'relative_std',
            'saturation_usvh',
        ):  # fmt: skip
            if not 0.0 <= getattr(self, name) < math.inf:
                raise ValueError(f'{name} is {getattr(self, name)}: must be at least 0')
        told = self.quantities
        for name in told:
            if name != 'skip' and told.count(name) > 1:
                raise ValueError(f'columns: {name} is named twice')
        if 'unix_time' in told and 'uptime' in told:
            raise ValueError('columns: must have unix_time or uptime, not both')
        self._require_dose_rate(told)

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of the columns."""
        return tuple(column.quantity for column in self.columns)

    def _require_dose_rate(self, told: tuple[str, ...]) -> None:
        has_window = 'window' in told or self.window_s > 0.0
        counts = 'count_rate' in told or ('counts' in told and has_window)
        if 'dose_rate' not in told and not (counts and self.sensitivity_cps_per_usvh):
            raise ValueError(
                'columns: must have dose_rate, or count_rate (or counts and window) and '
                'sensitivity_cps_per_usvh'
            )
        if not counts and 'dose_rate_std' not in told and not self.relative_std:
            raise ValueError('relative_std must be set: neither dose_rate_std nor counts are told')

    def measurement(self, line: str) -> LineMeasurement | None:
        """Return what `line` says; None if it is empty or a comment.

        Raises
        ------
        LineError
            If it does not follow the format.
        """
        text = line.strip()
        if not text or (self.comment and text.startswith(self.comment)):
            return None
        values = self._values(text.split(self.separator or None))
        window_s = values.get('window', self.window_s)
        counts = values.get('counts', round(values.get('count_rate', 0.0) * window_s))
        rate_usvh, std_usvh = self._dose_rate_usvh(values, counts, window_s)
        does_count = window_s > 0.0 and bool({'counts', 'count_rate'} & values.keys())
        is_over = 0.0 < self.saturation_usvh <= rate_usvh
        return LineMeasurement(
            clock_s=values.get('unix_time', values.get('uptime')),
            dose_rate_usvh=rate_usvh,
            dose_rate_std_usvh=std_usvh,
            counts=int(counts),
            window_s=window_s,
            live_time_s=values.get('live_time', window_s if does_count else math.nan),
            is_saturated=is_over or bool(values.get('saturated', 0.0)),
        )

    def _values(self, fields: list[str]) -> dict[str, float]:
        if len(fields) != len(self.columns):
            raise LineError(f'wrong number of columns: {len(fields)}, not {len(self.columns)}')
        values: dict[str, float] = {}
        for column, field in zip(self.columns, fields, strict=True):
            if column.quantity != 'skip':
                values[column.quantity] = _number(column, field)
        return values

    def _dose_rate_usvh(
        self, values: Mapping[str, float], counts: float, window_s: float
    ) -> tuple[float, float]:
        """Return the dose rate and its standard deviation, uSv/h."""
        per_usvh, live_s = self.sensitivity_cps_per_usvh, values.get('live_time', window_s)
        if 'dose_rate' in values:
            told_usvh = rate_usvh = values['dose_rate']
        elif 'count_rate' in values or live_s > 0.0:
            rate_cps = values['count_rate'] if 'count_rate' in values else counts / live_s
            told_usvh = rate_cps / per_usvh
            rate_usvh = max(0.0, rate_cps - self.dark_rate_cps) / per_usvh
        else:
            raise LineError('no time: the window is 0 s long')
        if 'dose_rate_std' in values:
            return rate_usvh, values['dose_rate_std']
        if self.relative_std:
            return rate_usvh, self.relative_std * rate_usvh
        if counts:
            return rate_usvh, told_usvh / math.sqrt(counts)
        # No count: up to about one may have been missed.
        known = per_usvh > 0.0 and live_s > 0.0
        return rate_usvh, 1.0 / live_s / per_usvh if known else rate_usvh


@dataclass(frozen=True, slots=True, kw_only=True)
class LineFormats:
    """All formats of a file."""

    formats: tuple[LineFormat, ...]

    def of(self, name: str) -> LineFormat:
        """Return the format `name`.

        Raises
        ------
        ValueError
            Naming those that there are.
        """
        for one in self.formats:
            if one.name == name:
                return one
        known = ', '.join(one.name for one in self.formats)
        raise ValueError(f'format is {name!r}: must be one of {known}')


def read_format(name: str, path: Path | None = None) -> LineFormat:
    """Return the format `name` of the file at `path`, or of those that are built in.

    Raises
    ------
    ValueError
        With one line for each mistake in the file, or if it has no such format.
    """
    return read_values(BUILT_IN if path is None else path, LineFormats).of(name)


def _number(column: LineColumn, field: str) -> float:
    try:
        value = float(field) * UNITS[column.quantity][column.unit]
    except ValueError:
        raise LineError(f'no number: {column.quantity} is {field.strip()[:20]!r}') from None
    if not 0.0 <= value <= LARGEST[column.quantity]:
        raise LineError(f'out of range: {column.quantity} is {value:g}')
    return value
