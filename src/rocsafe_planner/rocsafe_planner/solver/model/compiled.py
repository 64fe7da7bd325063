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


def _digest(*sources: Path) -> str:
    """Return a digest of the text of some modules."""
    digest = hashlib.sha256()
    for source in sources:
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def cache_directory() -> Path:
    """Return where machine code is kept: beside the sources or else in the user's cache.

    A change of a module can change the code of kernels in others, into which it was inlined:
    machine code is therefore kept apart by the text of all modules of the solver.
    """
    directory = Path(__file__).resolve().parents[1]
    name = f'{CACHE_PREFIX}{_digest(*sorted(directory.rglob("*.py")))}'
    if os.access(directory, os.W_OK):
        return directory / '__pycache__' / name
    return Path.home() / '.cache' / 'rocsafe' / name


_CACHE_DIRECTORY = cache_directory()


class KeptCode:
    """Where numba keeps the machine code of a function, and which text it belongs to.

    The text tells, not its place and time: code that comes with a wheel is used wherever that is
    unpacked.
    """

    def __init__(self, function: Callable[..., Any], source: str) -> None:
        self._stamp = _digest(Path(source))
        self._line = function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, function: Callable[..., Any], source: str) -> 'KeptCode | None':
        """Return the place for a function, or None where nothing can be kept."""
        place = cls(function, source)
        try:
            place.ensure_cache_path()
        except OSError:
            return None
        return place

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        _CACHE_DIRECTORY.mkdir(parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        """Return the folder."""
        return str(_CACHE_DIRECTORY)

    def get_source_stamp(self) -> str:
        """Return what changes with the source."""
        return self._stamp

    def get_disambiguator(self) -> str:
        """Return what tells functions of one name in one module apart."""
        return str(self._line)


if IS_COMPILED and not config.CPU_NAME:
    # Machine code for every processor of a kind: it can be shipped, and is as quick here.
    config.CPU_NAME, config.CPU_FEATURES = 'generic', ''


def _compile(function: Function, **options: bool) -> Function:
    """Compile a function with the options that all kernels share."""
    if not IS_COMPILED:
        return function
    return cast(
        'Function', numba.njit(nogil=True, error_model='numpy', _nrt=False, **options)(function)
    )


def _kept(function: Function) -> Function:
    """Compile a function and keep its machine code on disk."""
    previous = config.CACHE_LOCATOR_CLASSES
    config.CACHE_LOCATOR_CLASSES = f'{__name__}.{KeptCode.__name__}'
    try:
        return _compile(function, cache=True)
    except RuntimeError:  # No folder is writable: compile in each process.
        return _compile(function)
    finally:
        config.CACHE_LOCATOR_CLASSES = previous


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
