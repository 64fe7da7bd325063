# SPDX-License-Identifier: Apache-2.0
"""File of the state of a ground vehicle, from which a restarted process drives on."""

import json
from dataclasses import asdict
from pathlib import Path

from rocsafe_geo.storage.durable import replace_whole
from rocsafe_geo.storage.value_file import values_of
from rocsafe_sim.driving.drive_state import DriveMode, DriveOutcome, DriveState
from rocsafe_sim.errors import JournalError

FORMAT = 1


def write_drive(path: Path, state: DriveState) -> None:
    """Write the state as JSON, atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({'format': FORMAT, **asdict(state)}, default=_plain)
    replace_whole(path, text.encode())


def read_drive(path: Path) -> DriveState | None:
    """Return the state written to `path`, None if there is no such file.

    Raises
    ------
    JournalError
        If the file is not such a state.
    """
    try:
        fields = json.loads(path.read_text())
        found = fields.pop('format')
        if found != FORMAT:
            raise JournalError(f'{path}: format is {found}: must be {FORMAT}')
        return values_of(fields, DriveState, path.name)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise JournalError(f'{path}: not the journal of a drive: {error!r}') from error


def _plain(value: object) -> object:
    if isinstance(value, (DriveMode, DriveOutcome)):
        return value.value
    raise TypeError(f'{type(value).__name__} has no place in a journal')
