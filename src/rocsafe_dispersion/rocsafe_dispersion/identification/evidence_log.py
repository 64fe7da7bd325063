# SPDX-License-Identifier: Apache-2.0
"""Evidence of a running flight: readings of detectors and reports of people, each once."""

from collections.abc import Iterator, Mapping

from rocsafe_dispersion.identification.evidence import Evidence, Report
from rocsafe_dispersion.identification.flight_reports import flight_reports
from rocsafe_dispersion.mission_gas.gas_log import GasFlightReading
from rocsafe_hazard.row_spool import RowSpool

REPORTS_FILE = 'reports.csv'
MOST_REPORTS, LONGEST_WORDS = 1000, 200
_COLUMNS = ('observation', 'is_true', 'witness', 'time', 'latitude_deg', 'longitude_deg',
            'un_number')  # fmt: skip


class EvidenceLog:
    """Collects readings and reports; the newest placard counts."""

    def __init__(self) -> None:
        self._readings: dict[tuple[str, str, int], GasFlightReading] = {}
        self._reports: list[Report] = []
        self._un_number: int | None = None
        self._changes = 0
        self.newest_ns = 0

    def __len__(self) -> int:
        return self._changes

    def add_gas(self, reading: GasFlightReading) -> bool:
        """Add a reading and return whether it is usable and new."""
        key = (reading.vehicle, reading.sensor, reading.time_ns)
        if key in self._readings or not reading.is_usable:
            return False
        self._readings[key] = reading
        self._changes += 1
        self.newest_ns = max(self.newest_ns, reading.time_ns)
        return True

    def add_said(self, said: Report | int) -> bool:
        """Add a report, or the UN number of a placard, and return whether it is new.

        Raises
        ------
        ValueError
            If there are too many reports, words are too long, or there is no such number.
        """
        is_new = self._placard(said) if isinstance(said, int) else self._report(said)
        self._changes += is_new
        return is_new

    def _report(self, report: Report) -> bool:
        if report in self._reports:
            return False
        if len(self._reports) >= MOST_REPORTS:
            raise ValueError(f'{MOST_REPORTS} reports are kept: must be no more')
        for name in ('witness', 'time'):
            if len(getattr(report, name)) > LONGEST_WORDS:
                raise ValueError(f'{name} must have at most {LONGEST_WORDS} characters')
        self._reports.append(report)
        return True

    def _placard(self, un_number: int) -> bool:
        before, self._un_number = self._un_number, Evidence(un_number=un_number).un_number
        return before != un_number

    def evidence(self) -> Evidence:
        """Return all of it; of readings, those around the clearest one."""
        return Evidence(
            reports=tuple(self._reports),
            sensors=flight_reports(self._readings.values()),
            un_number=self._un_number,
        )


class ReportSpool:
    """Keeps reports in ``reports.csv`` of a directory; with no name, keeps none."""

    def __init__(self, directory: str) -> None:
        self._rows = RowSpool(directory, REPORTS_FILE, _COLUMNS)

    def restore(self, log: EvidenceLog) -> None:
        """Add all reports that were kept before to a log.

        Raises
        ------
        SpoolError
            If there is a file that cannot be read.
        """
        for row in self._rows.restored():
            for said in _said(row):
                log.add_said(said)

    def keep(self, said: Report | int) -> None:
        """Append a report, or the number of a placard; a `SpoolError` says why it cannot."""
        if isinstance(said, int):
            self._rows.keep(('', '', '', '', '', '', said))
            return
        place = said.place_deg or ('', '')
        self._rows.keep((said.observation, int(said.is_true), said.witness, said.time, *place, ''))


def _said(row: Mapping[str, str]) -> Iterator[Report | int]:
    """Yield what a row says, nothing if the row is not whole."""
    try:
        if row['un_number']:
            yield int(row['un_number'])
            return
        place = (row['latitude_deg'], row['longitude_deg'])
        yield Report(
            observation=row['observation'],
            is_true=row['is_true'] == '1',
            witness=row['witness'],
            time=row['time'],
            place_deg=(float(place[0]), float(place[1])) if all(place) else None,
        )
    except (KeyError, TypeError, ValueError):
        return
