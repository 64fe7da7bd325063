# SPDX-License-Identifier: Apache-2.0
"""File of the record of a vehicle, from which a restarted process continues its flight."""

from pathlib import Path

from rocsafe_sim.vehicle.flight_record import VehicleRecord
from rocsafe_sim.vehicle.journal_file import read_record, write_record

FORMAT = 7


def write_journal(path: Path, record: VehicleRecord) -> None:
    """Write `record` as JSON, atomically."""
    write_record(path, record, FORMAT)


def read_journal(path: Path) -> VehicleRecord | None:
    """Return the record written to `path`, None if there is no such file.

    Raises
    ------
    JournalError
        If the file is not such a record.
    """
    return read_record(path, VehicleRecord, FORMAT, 'a vehicle journal')
