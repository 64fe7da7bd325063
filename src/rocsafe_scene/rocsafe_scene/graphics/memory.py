# SPDX-License-Identifier: Apache-2.0
"""Return of unused memory to the operating system."""

import ctypes
import mmap
from typing import Any

import numpy as np
from numpy.typing import NDArray


def return_freed_memory() -> None:
    """Return freed memory to the operating system; the C library keeps small freed blocks."""
    free = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if free is not None:
        free(0)


def drop_mapped_pages(values: NDArray[Any]) -> None:
    """Drop the pages of a memory-mapped array from memory; they are read again when needed."""
    file = getattr(values, '_mmap', None) if isinstance(values, np.memmap) else None
    if isinstance(file, mmap.mmap):
        file.madvise(mmap.MADV_DONTNEED)
