# SPDX-License-Identifier: Apache-2.0
"""Readings of gas and wind of a flight in files, so that a restart loses none."""

from collections.abc import Iterator, Mapping
from dataclasses import astuple, fields
from typing import Any, TypeVar

from rocsafe_dispersion.mission_gas.gas_log import GasFlightReading, GasLog, WindFlightReading
from rocsafe_hazard.row_spool import RowSpool

GAS_FILE, WIND_FILE = 'gas.csv', 'wind.csv'
Reading = TypeVar('Reading', GasFlightReading, WindFlightReading)
_WORDS = ('vehicle', 'sensor', 'unit', 'calibration_gas')


class GasSpool:
    """Keeps readings in ``gas.csv`` and ``wind.csv`` of a directory; with no name, keeps none."""

    def __init__(self, directory: str) -> None:
        self._gas = RowSpool(directory, GAS_FILE, _columns(GasFlightReading))
        self._wind = RowSpool(directory, WIND_FILE, _columns(WindFlightReading))

    def restore(self, log: GasLog) -> None:
        """Add all readings that were kept before to a log.

        Raises
        ------
        SpoolError
            If there is a file that cannot be read.
        """
        for gas in self.gas():
            log.add_gas(gas)
        for row in self._wind.restored():
            if (wind := _reading(WindFlightReading, row)) is not None:
                log.add_wind(wind)

    def gas(self) -> Iterator[GasFlightReading]:
        """Yield the readings of gas that were kept before; a `SpoolError` says why it cannot."""
        for row in self._gas.restored():
            if (reading := _reading(GasFlightReading, row)) is not None:
                yield reading

    def keep_gas(self, reading: GasFlightReading) -> None:
        """Append a reading; a `SpoolError` says why it cannot."""
        self._gas.keep(_cells(reading))

    def keep_wind(self, reading: WindFlightReading) -> None:
        """Append a reading; a `SpoolError` says why it cannot."""
        self._wind.keep(_cells(reading))


def _columns(kind: type[GasFlightReading] | type[WindFlightReading]) -> tuple[str, ...]:
    return tuple(one.name for one in fields(kind))


def _cells(reading: GasFlightReading | WindFlightReading) -> list[object]:
    return [int(cell) if isinstance(cell, bool) else cell for cell in astuple(reading)]


def _reading(kind: type[Reading], row: Mapping[str, str]) -> Reading | None:
    """Return the reading of a row, None if the row is not whole."""
    try:
        return kind(**{name: _value(name, row[name]) for name in _columns(kind)})
    except (KeyError, TypeError, ValueError):
        return None


def _value(name: str, text: str) -> Any:
    if name in _WORDS:
        return str(text)
    if name == 'time_ns':
        return int(text)
    return text == '1' if name == 'is_saturated' else float(text)
