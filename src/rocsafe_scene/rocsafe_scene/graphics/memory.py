# SPDX-License-Identifier: Apache-2.0
"""Memory that is no longer needed, given back to the machine."""

import ctypes
import mmap
from typing import Any

import numpy as np
from numpy.typing import NDArray


def return_freed_memory() -> None:
    """Give back what was freed in many small parts, which the C library otherwise keeps."""
    free = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if free is not None:
        free(0)


def drop_mapped_pages(values: NDArray[Any]) -> None:
    """Drop what of `values` was read from a file they are mapped from; it can be read again."""
    file = getattr(values, '_mmap', None) if isinstance(values, np.memmap) else None
    if isinstance(file, mmap.mmap):
        file.madvise(mmap.MADV_DONTNEED)
