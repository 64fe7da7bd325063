# SPDX-License-Identifier: Apache-2.0
"""File of the record of a vehicle, from which a restarted process continues its flight.

The shortest decimal form of a float reads back as the same float: nothing is rounded.
"""

import json
from dataclasses import asdict
from pathlib import Path

from rocsafe_geo.storage.durable import replace_whole
from rocsafe_geo.storage.value_file import values_of
from rocsafe_sim.errors import JournalError
from rocsafe_sim.flight.commands import CommandKind
from rocsafe_sim.vehicle.flight_record import FlightOutcome, VehicleRecord

FORMAT = 7


def write_journal(path: Path, record: VehicleRecord) -> None:
    """Write `record` as JSON, atomically."""
    text = json.dumps({'format': FORMAT, **asdict(record)}, default=_plain)
    replace_whole(path, text.encode())


def read_journal(path: Path) -> VehicleRecord | None:
    """Return the record written to `path`, None if there is no such file.

    Raises
    ------
    JournalError
        If the file is not such a record.
    """
    try:
        fields = json.loads(path.read_text(), parse_constant=_refuse)
        found = fields.pop('format')
        if found != FORMAT:
            raise JournalError(f'{path}: format is {found}: must be {FORMAT}')
        return values_of(fields, VehicleRecord, path.name)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise JournalError(f'{path}: not a vehicle journal: {error!r}') from error


def _plain(value: object) -> object:
    if isinstance(value, (FlightOutcome, CommandKind)):
        return value.value
    raise TypeError(f'{type(value).__name__} has no place in a journal')


def _refuse(constant: str) -> None:
    raise ValueError(f'{constant}: must be finite')
