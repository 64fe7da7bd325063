# SPDX-License-Identifier: Apache-2.0
"""Rows of a CSV file with a header; faults name line, column and value."""

import csv
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from rocsafe_geo.arrays import FloatArray

Row = dict[str, str]
T = TypeVar('T')


def read_table(path: Path, made: Callable[[Sequence[Row]], T]) -> T:
    """Return what `made` makes of the rows of a file.

    Raises
    ------
    ValueError
        In one line that begins with the path, if the file cannot be read or `made` refuses it.
    """
    try:
        with path.open(encoding='utf-8-sig', newline='') as stream:
            reader = csv.DictReader(stream, strict=True)
            _check_names(reader.fieldnames or ())
            return made(list(reader))
    except (OSError, ValueError, csv.Error) as error:
        raise ValueError(f'{path}: {error}') from error


def _check_names(names: Sequence[str]) -> None:
    """Refuse a header whose columns no program could tell apart."""
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f'column {twice[0]!r} is there {names.count(twice[0])} times: once')
    for mark, word in ((';', 'semicolons'), ('\t', 'tabs')):
        if len(names) == 1 and mark in names[0]:
            raise ValueError(f'line 1: {word} stand between the columns: must be commas')


def column(rows: Sequence[Row], name: str) -> FloatArray:
    """Return the numbers of a column, (n,).

    Raises
    ------
    ValueError
        If the column is missing, or a value is not a finite number.
    """
    if name not in rows[0]:
        raise ValueError(f'column {name} is missing')
    return np.array([number_in(line, row, name) for line, row in enumerate(rows, 2)])


def number_in(line: int, row: Row, name: str) -> float:
    """Return the number in a column of the row in line `line` of the file.

    Raises
    ------
    ValueError
        If it is not a finite number.
    """
    text = row.get(name)
    try:
        value = float(text or '')
    except (TypeError, ValueError):
        raise ValueError(f'line {line}: {name} is {text!r}: must be a number') from None
    if not math.isfinite(value):
        raise ValueError(f'line {line}: {name} is {text!r}: must be finite')
    return value
