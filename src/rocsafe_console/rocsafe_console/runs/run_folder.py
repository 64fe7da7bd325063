# SPDX-License-Identifier: Apache-2.0
"""Runs in a folder, and what the page shows of a finished one."""

import base64
import csv
import fcntl
import json
import math
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rocsafe_console.errors import ConsoleError
from rocsafe_geo.evidence.evidence_log import LOG_NAME, segments_of
from rocsafe_console.runs.recorded_flight import tracks_of

_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9._-]{0,150}')
# Files that may be fetched of a run; pictures and tiles besides.
FILES = frozenset(
    {
        'report.html', 'summary.json', 'scenario.yaml', 'plan.json', 'plan.geojson', 'plan.kml',
        'plan.png', 'readings.csv', 'cordons.geojson', 'cordons.kml', 'sources.geojson',
        'sources.json', 'dose_map.tif', 'mosaic.tif', 'mission.mcap', 'evidence.jsonl', 'run.json',
    }
)  # fmt: skip
_TILE = re.compile(r'map/tiles/(\d{1,2}/\d{1,7}/\d{1,7}\.png)')
_SEALED = re.compile(r'seal-\d{4}\.json|evidence-\d{4}\.jsonl')
_MOST_POINTS = 4000
_REPLAYED = frozenset(
    {'decision', 'state', 'alarm', 'event', 'photograph', 'order', 'outcome', 'mark'}
)
# One transparent pixel.
EMPTY_TILE = base64.b64decode(
    'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGNgYGBgAAAABQABpfZFQAAAAABJRU5ErkJggg=='
)


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRow:
    """A run as the list of the page shows it; what has no outcome and no process can be resumed."""

    name: str
    outcome: str
    started: str
    has_report: bool
    is_sealed: bool
    can_resume: bool


def runs_in(folder: Path) -> list[dict[str, Any]]:
    """Return the runs in a folder, the newest first, fit for JSON."""
    found = [path for path in folder.glob('*/scenario.yaml') if _NAME.fullmatch(path.parent.name)]
    found.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    return [asdict(_row(path.parent)) for path in found]


def run_in(folder: Path, name: str) -> Path:
    """Return the folder of a run.

    Raises
    ------
    ConsoleError
        If there is no run of this name.
    """
    path = folder / name
    if not _NAME.fullmatch(name) or not (path / 'scenario.yaml').is_file():
        raise ConsoleError(f'run {name!r}: there is none')
    return path


def file_of(run: Path, name: str) -> Path:
    """Return a file of a run that may be fetched; raises `ConsoleError`."""
    is_known = name in FILES or _TILE.fullmatch(name) or _SEALED.fullmatch(name)
    path = run / name
    if not is_known or not path.is_file() or not path.resolve().is_relative_to(run.resolve()):
        raise ConsoleError(f'{run.name} has no file {name!r} to fetch')
    return path


def is_tile(name: str) -> bool:
    """Return whether `name` is that of a tile of a map; there is none where nothing was seen."""
    return _TILE.fullmatch(name) is not None


def replay_of(run: Path) -> dict[str, Any]:
    """Return what the page needs to replay a run: sections as of a live one, and series.

    What a run does not have is left out.
    """
    series, tracks = _series(run / 'readings.csv'), tracks_of(run / 'mission.mcap')
    told = [one['time_s'] for one in (*series.values(), *tracks.values()) if one['time_s']]
    times = [time_s for one in told for time_s in (one[0], one[-1])]
    return {
        'name': run.name,
        'begin_s': min(times, default=0.0),
        'end_s': max(times, default=0.0),
        'series': series,
        'tracks': tracks,
        'plan': _json(run / 'plan.geojson'),
        'cordons': _json(run / 'cordons.geojson'),
        'sources': _json(run / 'sources.geojson'),
        'summary': _json(run / 'summary.json'),
        'tiles': _tiles(run / 'map' / 'tiles'),
        'has_report': (run / 'report.html').is_file(),
        'evidence': [one for path in segments_of(run / LOG_NAME) for one in _evidence(path)],
    }


def is_flying(run: Path) -> bool:
    """Return whether the mission of a run goes on: it holds the lock of its folder."""
    if (_json(run / 'run.json') or {}).get('outcome'):
        return False
    try:
        with (run / 'run.lock').open('rb') as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except FileNotFoundError:
        return False
    except OSError:
        return True
    return False


def _row(run: Path) -> RunRow:
    info = _json(run / 'run.json') or {}
    return RunRow(
        name=run.name,
        outcome=str(info.get('outcome') or ('flying' if is_flying(run) else 'not ended')),
        started=str(info.get('started', '')),
        has_report=(run / 'report.html').is_file(),
        is_sealed=any(run.glob('seal-*.json')),
        can_resume=(run / 'session.json').is_file() and not is_flying(run),
    )


def _json(path: Path) -> Any:
    """Return the content of a file, None if it is not there or torn."""
    try:
        return json.loads(path.read_text(encoding='utf-8'))
    except (OSError, ValueError):
        return None


def _series(path: Path) -> dict[str, dict[str, list[float]]]:
    """Return times, places and dose rates of each vehicle; of close ones the highest is kept."""
    series: dict[str, dict[str, list[float]]] = {}
    for name, *row in _rows(path):
        one = series.setdefault(
            name, {'time_s': [], 'latitude_deg': [], 'longitude_deg': [], 'dose_rate_usvh': []}
        )
        for key, value in zip(one, row, strict=True):
            one[key].append(value)
    return {name: _thinned(one) for name, one in series.items()}


def _rows(path: Path) -> Iterator[tuple[Any, ...]]:
    if not path.is_file():
        return
    keys = ('latitude_deg', 'longitude_deg', 'dose_rate_usvh')
    with path.open(encoding='utf-8', newline='') as file:
        for row in csv.DictReader(file):
            try:
                values = [float(row[key]) for key in keys]
                time_s = int(row['time_ns']) / 1e9
            except (KeyError, TypeError, ValueError):
                continue
            if all(map(math.isfinite, values)):
                yield (row['vehicle'], time_s, *values)


def _thinned(one: dict[str, list[float]]) -> dict[str, list[float]]:
    rates = one['dose_rate_usvh']
    step = max(math.ceil(len(rates) / _MOST_POINTS), 1)
    starts = range(0, len(rates), step)
    kept = [max(range(a, min(a + step, len(rates))), key=rates.__getitem__) for a in starts]
    return {key: [values[index] for index in kept] for key, values in one.items()}


def _tiles(folder: Path) -> dict[str, Any] | None:
    """Return zooms, and the first and last column and row of the largest zoom; None: no tiles."""
    zooms = sorted(int(path.name) for path in folder.glob('[0-9]*'))
    found = [
        (int(path.parent.name), int(path.stem)) for path in folder.glob(f'{max(zooms, default=0)}/*/*.png')
    ]
    if not found:
        return None
    columns, rows = zip(*found, strict=True)
    return {
        'zooms': zooms,
        'columns': [min(columns), max(columns)],
        'rows': [min(rows), max(rows)],
    }


def _evidence(path: Path) -> Iterator[dict[str, Any]]:
    for line in path.read_bytes().split(b'\n')[:-1]:
        try:
            entry = json.loads(line)
        except ValueError:
            return
        if entry.get('kind') in _REPLAYED:
            yield entry
