# SPDX-License-Identifier: Apache-2.0
"""What people decided at the console during a run, from its evidence log."""

import json
import math
from collections.abc import Callable, Mapping
from datetime import datetime, timezone
from pathlib import Path
from typing import Any

from rocsafe_geo.evidence.evidence_log import DAMAGED, LOG_NAME, segments_of

Entry = Mapping[str, Any]
Row = tuple[str, ...]


def people_rows(folder: Path) -> list[Row]:
    """Return time (UTC), user, decision and result of each decision in the log of a run.

    A line that cannot be read has a row that says so: `rocsafe verify` tells what was changed.
    """
    named = [
        (f'line {number} of {path.name}', _entry(line))
        for path in segments_of(folder / LOG_NAME)
        for number, line in enumerate(_lines(path), 1)
    ]
    results = {
        entry['request_id']: _result(entry)
        for _, entry in named
        if entry is not None and entry.get('kind') == 'outcome' and 'request_id' in entry
    }
    rows: list[Row] = []
    for name, entry in named:
        if entry is None:
            rows.append(('', '', f'{name} cannot be read', ''))
        elif entry['kind'] in _TOLD:
            why = str(entry.get('why', '')) if entry['kind'] == 'refused' else ''
            result = results.get(str(entry.get('request_id')), why)
            told = _TOLD[entry['kind']](entry)
            rows.append((_clock(entry['time_s']), str(entry['by']), told, result))
    return rows


def _lines(path: Path) -> list[str]:
    try:
        return path.read_text(encoding='utf-8', errors='replace').splitlines()
    except OSError:
        return []


def _entry(line: str) -> Entry | None:
    try:
        entry: Entry = json.loads(line)
        is_whole = isinstance(entry['kind'], str) and math.isfinite(entry['time_s'])
    except (ValueError, KeyError, TypeError):
        return None
    return entry if is_whole and 'by' in entry else None


def _clock(time_s: float) -> str:
    return f'{datetime.fromtimestamp(time_s, tz=timezone.utc):%H:%M:%S}'


def _order(entry: Entry) -> str:
    vehicles = ', '.join(map(str, entry.get('vehicles', ()))) or 'no vehicle'
    return f'{str(entry.get("verb", "order")).replace("_", " ")}: {vehicles}'


def _result(entry: Entry) -> str:
    found = entry.get('results')
    if not isinstance(found, list):
        return ''
    return '; '.join(
        ' '.join(str(one[key]) for key in ('vehicle', 'outcome', 'text') if one.get(key))
        for one in found
        if isinstance(one, dict)
    )


def _mark(entry: Entry) -> str:
    return f'marked as evidence at {entry.get("mgrs", "")}: {entry.get("text", "")}'


def _refused(entry: Entry) -> str:
    asked = entry.get('asked')
    what = _order(asked) if isinstance(asked, dict) else str(entry.get('path', ''))
    return f'was refused: {what}'


# Log-ins and what nodes told are in the log, too; here is what a person answers for.
_TOLD: Mapping[str, Callable[[Entry], str]] = {
    'order': _order,
    'refused': _refused,
    'mark': _mark,
    'acknowledge': lambda entry: f'alarm seen: {entry.get("alarm", "")}',
    'launch': lambda entry: f'launched {entry.get("name", "")}',
    'seal': lambda _: 'sealed the run',
    DAMAGED: lambda entry: f'found the log damaged, and began another: {entry.get("why", "")}',
}
