# SPDX-License-Identifier: Apache-2.0
"""File of the state of a ground vehicle, from which a restarted process drives on."""

from pathlib import Path

from rocsafe_sim.driving.drive_state import DriveState
from rocsafe_sim.vehicle.journal_file import read_record, write_record

FORMAT = 1


def write_drive(path: Path, state: DriveState) -> None:
    """Write the state as JSON, atomically."""
    write_record(path, state, FORMAT)


def read_drive(path: Path) -> DriveState | None:
    """Return the state written to `path`, None if there is no such file.

    Raises
    ------
    JournalError
        If the file is not such a state.
    """
    return read_record(path, DriveState, FORMAT, 'the journal of a drive')
