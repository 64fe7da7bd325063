# SPDX-License-Identifier: Apache-2.0
"""The table of a campaign: ``results.csv``, and ``results.parquet`` where pyarrow is."""

import csv
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rocsafe_campaign.results.metrics import METRICS
from rocsafe_campaign.results.row import Row
from rocsafe_geo.storage.durable import write_whole

FIRST = ('number', 'key', 'seed', 'repeat')
LAST = ('outcome', 'text')


def write_table(folder: Path, rows: Sequence[Row], keys: Sequence[str]) -> list[Path]:
    """Write the table of all rows in the order of their numbers; return its files."""
    head, body = (*FIRST, *keys, *LAST, *METRICS), [_cells(row, keys) for row in rows]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(head)
    writer.writerows([_text(cell) for cell in cells] for cells in body)
    path = folder / 'results.csv'
    write_whole(path, text.getvalue().encode())
    return [path, *_parquet(folder, head, body)]


def _cells(row: Row, keys: Sequence[str]) -> list[Any]:
    return [
        *(getattr(row, name) for name in FIRST),
        *(row.inputs[key] for key in keys),
        *(getattr(row, name) for name in LAST),
        *(getattr(row.metrics, name) for name in METRICS),
    ]


def _text(cell: Any) -> Any:
    if isinstance(cell, float):
        return '' if math.isnan(cell) else repr(cell)
    return ' '.join(map(str, cell)) if isinstance(cell, (tuple, list)) else cell


def _parquet(folder: Path, head: Sequence[str], body: Sequence[Sequence[Any]]) -> list[Path]:
    try:
        import pyarrow
        from pyarrow import parquet
    except ModuleNotFoundError:
        return []
    columns = {name: [_alike(row[k]) for row in body] for k, name in enumerate(head)}
    path = folder / 'results.parquet'
    parquet.write_table(pyarrow.table(columns), path)
    return [path]


def _alike(cell: Any) -> Any:
    return list(cell) if isinstance(cell, tuple) else cell
