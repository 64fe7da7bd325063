# SPDX-License-Identifier: Apache-2.0
"""Memory allocation of the process."""

import ctypes

# Numbers of <malloc.h>.
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
KEPT_BYTES, LARGEST_KEPT_BYTES = 128 * 2**20, 32 * 2**20


def keep_freed_memory() -> None:
    """Let the C library keep freed memory for the next pictures.

    By default glibc returns the memory of each picture to the system and asks for it again, with a
    page fault for each 4 KiB: a tenth of the time of a map. Other libraries are left as they are.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):
        return
    mallopt(M_MMAP_THRESHOLD, LARGEST_KEPT_BYTES)
    mallopt(M_TRIM_THRESHOLD, KEPT_BYTES)
