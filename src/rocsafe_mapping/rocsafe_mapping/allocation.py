# SPDX-License-Identifier: Apache-2.0
"""How the process gets its memory."""

import ctypes

# Numbers of <malloc.h>.
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
KEPT_BYTES, LARGEST_KEPT_BYTES = 128 * 2**20, 32 * 2**20


def keep_freed_memory() -> None:
    """Let the C library keep the memory of pictures that were freed for the next ones.

    glibc else returns each to the system and gets it anew, a page fault for every 4 KiB: a tenth
    of the time of a map. Where the library is another one nothing changes.
    """
    try:
        mallopt = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError):
        return
    mallopt(M_MMAP_THRESHOLD, LARGEST_KEPT_BYTES)
    mallopt(M_TRIM_THRESHOLD, KEPT_BYTES)
