# SPDX-License-Identifier: Apache-2.0
"""Rows of a CSV file with a header; faults name line, column and value."""

import csv
import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TextIO, TypeVar

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.storage.named_file import require_file

T = TypeVar('T')
# A longer line is no row of a table: it is not read to its end.
LONGEST_LINE = 10_000
# What loggers write where there is no number.
NOTHING = {'', '-', '--', 'nan', 'na', 'n/a', 'none', 'null'}
UTF_16_MARKS = (b'\xff\xfe', b'\xfe\xff')


class Row(dict[str, str]):
    """A row: values by the names of their columns.

    Attributes
    ----------
    line
        Number of its line in the file, from 1.
    """

    __slots__ = ('line',)

    def __init__(self, line: int, values: Iterator[tuple[str, str]]) -> None:
        super().__init__(values)
        self.line = line


def read_table(path: Path, made: Callable[[Sequence[Row]], T], most_rows: int) -> T:
    """Return what `made` makes of the rows of a file, of which there is at least one.

    Parameters
    ----------
    path
        A file in UTF-8, or in UTF-16 with a byte order mark.
    made
        Makes a value of the rows.
    most_rows
        A file with more rows is refused, and not read further.

    Raises
    ------
    ValueError
        In one line that begins with the path, if the file cannot be read or `made` refuses it.
    """
    try:
        require_file(path)
        with path.open(encoding=_encoding(path), newline='') as stream:
            return made(_rows(stream, most_rows))
    except OSError as error:
        raise ValueError(f'{path}: {error.strerror}') from error
    except UnicodeError as error:
        raise ValueError(f'{path}: is neither UTF-8 nor UTF-16 text') from error
    except (ValueError, csv.Error) as error:
        raise ValueError(f'{path}: {error}') from error


def _encoding(path: Path) -> str:
    with path.open('rb') as stream:
        return 'utf-16' if stream.read(2) in UTF_16_MARKS else 'utf-8-sig'


def _rows(stream: TextIO, most_rows: int) -> list[Row]:
    """Return the rows; blank ones are left out."""
    reader = csv.reader(_lines(stream), strict=True)
    names = [name.strip() for name in next(reader, [])]
    _check_names(names)
    found: list[Row] = []
    for values in reader:
        if not values:
            continue
        if len(values) != len(names):
            raise ValueError(
                f'line {reader.line_num}: has {len(values)} values: must be {len(names)}, '
                'as many as the first line has names (decimals have points)'
            )
        if len(found) == most_rows:
            raise ValueError(f'has more than {most_rows} rows: must be 1 to {most_rows}')
        found.append(Row(reader.line_num, zip(names, values, strict=True)))
    if not found:
        raise ValueError('has 0 rows below the names of its columns: must have one')
    return found


def _lines(stream: TextIO) -> Iterator[str]:
    number = 0
    while line := stream.readline(LONGEST_LINE + 1):
        number += 1
        if len(line) > LONGEST_LINE:
            raise ValueError(f'line {number}: is longer than {LONGEST_LINE} characters')
        if '\0' in line:
            raise ValueError(f'line {number}: holds a byte 0: must be text')
        yield line


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
    return np.array([number_in(row, name) for row in rows])


def has_all(row: Row, names: Sequence[str]) -> bool:
    """Return whether a row has something in all columns of `names` that the file has."""
    return all(row[name].strip().lower() not in NOTHING for name in names if name in row)


def number_in(row: Row, name: str) -> float:
    """Return the number in a column of a row.

    Raises
    ------
    ValueError
        If it is not a finite number.
    """
    text = row[name]
    try:
        value = float(text)
    except ValueError:
        comma = ' with a decimal point' if ',' in text else ''
        raise ValueError(f'line {row.line}: {name} is {text!r}: must be a number{comma}') from None
    if not math.isfinite(value):
        raise ValueError(f'line {row.line}: {name} is {text!r}: must be finite')
    return value
