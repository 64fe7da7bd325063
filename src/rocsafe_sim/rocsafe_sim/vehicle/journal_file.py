# SPDX-License-Identifier: Apache-2.0
"""Files of records from which restarted processes go on.

The shortest decimal form of a float reads back as the same float: nothing is rounded.
"""

import json
from dataclasses import asdict
from enum import Enum
from pathlib import Path
from typing import Any, TypeVar

from rocsafe_geo.storage.durable import replace_whole
from rocsafe_geo.storage.value_file import values_of
from rocsafe_sim.errors import JournalError

RecordT = TypeVar('RecordT')


def write_record(path: Path, record: Any, version: int) -> None:
    """Write a record, a dataclass, as JSON, atomically."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = json.dumps({'format': version, **asdict(record)}, default=_plain)
    replace_whole(path, text.encode())


def read_record(path: Path, record_type: type[RecordT], version: int, what: str) -> RecordT | None:
    """Return the record in a file, None if there is no such file.

    Raises
    ------
    JournalError
        If the file is not such a record; `what` names it.
    """
    try:
        fields = json.loads(path.read_text(), parse_constant=_refuse)
        found = fields.pop('format')
        if found != version:
            raise JournalError(f'{path}: format is {found}: must be {version}')
        return values_of(fields, record_type, path.name)
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise JournalError(f'{path}: not {what}: {error!r}') from error


def _plain(value: object) -> object:
    if isinstance(value, Enum):
        return value.value
    raise TypeError(f'{type(value).__name__} has no place in a journal')


def _refuse(constant: str) -> None:
    raise ValueError(f'{constant}: must be finite')
