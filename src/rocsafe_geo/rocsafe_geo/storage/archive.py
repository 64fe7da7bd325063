# SPDX-License-Identifier: Apache-2.0
"""NumPy archives (``.npz``) that hold a value."""

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

Arrays = dict[str, NDArray[Any]]
Value = TypeVar('Value')


def read_archive(what: str, path: Path, value_of: Callable[[Arrays], Value]) -> Value:
    """Return the value that `value_of` makes of the arrays in the file at `path`.

    Raises
    ------
    ValueError
        In one line with `what` and the path, if the file is not there or holds no such value.
    """
    if not path.is_file():
        raise ValueError(f'{what} {path}: no such file')
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
        return value_of(arrays)
    except KeyError as error:
        raise ValueError(f'{what} {path}: array {error.args[0]} is missing') from error
    except (OSError, ValueError, TypeError, IndexError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f'{what} {path}: {error}') from error
