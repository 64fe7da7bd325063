# SPDX-License-Identifier: Apache-2.0
"""Rows that a node keeps come back after it has been killed."""

import pytest

from rocsafe_hazard.row_spool import RowSpool, SpoolError

COLUMNS = ('time', 'value')


def test_rows_come_back_and_a_cut_row_does_not(tmp_path):
    """What a crash cut off is left out, and the rows after it are whole."""
    first = RowSpool(str(tmp_path), 'a.csv', COLUMNS)
    first.keep([1, 2.5])
    file = tmp_path / 'a.csv'
    file.write_text(file.read_text() + '2,3')
    assert list(RowSpool(str(tmp_path), 'a.csv', COLUMNS).restored()) == [
        {'time': '1', 'value': '2.5'}
    ]
    RowSpool(str(tmp_path), 'a.csv', COLUMNS).keep([3, 4.0])
    rows = list(RowSpool(str(tmp_path), 'a.csv', COLUMNS).restored())
    assert rows[-1] == {'time': '3', 'value': '4.0'}


def test_without_a_directory_nothing_is_kept():
    """And nothing comes back."""
    spool = RowSpool('', 'a.csv', COLUMNS)
    spool.keep([1, 2.0])
    assert list(spool.restored()) == []


def test_a_folder_that_is_a_file_is_told_by_name(tmp_path):
    """In one line."""
    (tmp_path / 'b').write_text('')
    with pytest.raises(SpoolError, match='cannot be written'):
        RowSpool(str(tmp_path / 'b'), 'a.csv', COLUMNS).keep([1, 2.0])
