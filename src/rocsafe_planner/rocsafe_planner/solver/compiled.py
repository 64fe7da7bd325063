# SPDX-License-Identifier: Apache-2.0
"""Compilation of the solver's inner loops, kept on disk so that only the first run ever waits."""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numba
import numpy as np
from numba import config

Function = TypeVar('Function', bound=Callable[..., Any])

if TYPE_CHECKING:
    # To the type checker whole numbers are whole numbers.
    Long = int
    Word = int
else:
    Long = np.int64
    """What every index in a kernel is turned into: one machine type, one specialisation."""
    Word = np.uint64
    """Random bits."""


def _sources_digest(directory: Path) -> str:
    """Return a digest of every module of the solver.

    numba notices a change of the file that holds a kernel, but not of the files whose kernels it
    has inlined: machine code is therefore kept apart by the text of all of them.
    """
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(directory.glob('*.py')):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _cache_directory() -> str:
    """Return where machine code is kept: beside the sources or else in the user's cache."""
    directory = Path(__file__).parent
    name = f'numba-{_sources_digest(directory)}'
    if os.access(directory, os.W_OK):
        return str(directory / '__pycache__' / name)
    return str(Path.home() / '.cache' / 'rocsafe' / name)


_CACHE_DIRECTORY = _cache_directory()


def _compile(function: Function, **options: bool) -> Function:
    """Hand a function to numba with the options that every kernel shares."""
    shared: dict[str, Any] = {'nogil': True, 'error_model': 'numpy', '_nrt': False}
    njit: Any = numba.njit
    settings: Any = config
    previous = settings.CACHE_DIR
    settings.CACHE_DIR = previous or _CACHE_DIRECTORY
    compiled: Function
    try:
        compiled = njit(cache=True, **shared, **options)(function)
    except RuntimeError:  # no writable place at all: compile anew in each process
        compiled = njit(**shared, **options)(function)
    finally:
        settings.CACHE_DIR = previous
    return compiled


def kernel(function: Function) -> Function:
    """Compile a function to machine code: without the interpreter lock, IEEE arithmetic kept.

    Fast-math stays off: sums must round alike on every machine, or two machines would part ways at
    the first nearly tied decision.
    """
    return _compile(function)


def inlined(function: Function) -> Function:
    """Compile a small function that is to vanish into the kernels that call it."""
    return _compile(function, forceinline=True)
