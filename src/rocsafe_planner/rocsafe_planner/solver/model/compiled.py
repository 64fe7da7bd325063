# SPDX-License-Identifier: Apache-2.0
"""Compilation of the solver's inner loops; the machine code is kept on disk.

Without numba the loops stay plain Python, and `solve` uses another method (see `plain`).
"""

import hashlib
import logging
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

numba: Any
config: Any
try:
    import numba
    from numba import config
except ImportError:  # numba is not installed
    numba = config = None

Function = TypeVar('Function', bound=Callable[..., Any])

if TYPE_CHECKING:
    # The type checker sees int.
    Long = int
    Word = int
else:
    Long = np.int64
    """What every index in a kernel is turned into: one machine type, one specialisation."""
    Word = np.uint64
    """Random bits."""

IS_COMPILED = numba is not None
"""Whether loops run as machine code."""
CACHE_PREFIX = 'numba-'

if not IS_COMPILED:
    logging.getLogger(__name__).warning(
        'numba is not installed: routes are planned by simple methods, which are worse and slower'
    )


def _sources_digest(directory: Path) -> str:
    """Return a digest of every module of the solver.

    numba notices a change of the file that holds a kernel, but not of the files whose functions
    it has inlined: machine code is therefore kept apart by the text of all of them.
    """
    digest = hashlib.sha256()
    for source in sorted(directory.rglob('*.py')):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def cache_directory() -> Path:
    """Return where machine code is kept: beside the sources or else in the user's cache."""
    # A workspace installs links to the sources: machine code is the same by either name.
    directory = Path(__file__).resolve().parents[1]
    name = f'{CACHE_PREFIX}{_sources_digest(directory)}'
    if os.access(directory, os.W_OK):
        return directory / '__pycache__' / name
    return Path.home() / '.cache' / 'rocsafe' / name


_CACHE_DIRECTORY = str(cache_directory())


def _compile(function: Function, **options: bool) -> Function:
    """Compile a function with the options that all kernels share."""
    if not IS_COMPILED:
        return function
    return cast(
        'Function', numba.njit(nogil=True, error_model='numpy', _nrt=False, **options)(function)
    )


def _kept(function: Function) -> Function:
    """Compile a function and keep its machine code on disk."""
    previous = config.CACHE_DIR
    config.CACHE_DIR = previous or _CACHE_DIRECTORY
    # numba files machine code by the name of the source.
    source = str(Path(function.__code__.co_filename).resolve())
    function.__code__ = function.__code__.replace(co_filename=source)
    try:
        return _compile(function, cache=True)
    except RuntimeError:  # No folder is writable: compile in each process.
        return _compile(function)
    finally:
        config.CACHE_DIR = previous


def kernel(function: Function) -> Function:
    """Compile a function that Python calls, and keep its machine code on disk.

    It runs without the interpreter lock. Fast-math stays off: sums must round alike on every
    machine, or two machines would decide differently where two choices are nearly equal.
    """
    return _kept(function) if IS_COMPILED else function


def inner(function: Function) -> Function:
    """Compile a function that only kernels call, without an interface for Python."""
    return _compile(function, no_cpython_wrapper=True, no_cfunc_wrapper=True)


def inlined(function: Function) -> Function:
    """Compile a small function that is inlined into the kernels that call it."""
    return _compile(function, no_cpython_wrapper=True, no_cfunc_wrapper=True, forceinline=True)
