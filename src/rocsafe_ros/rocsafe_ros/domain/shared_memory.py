# SPDX-License-Identifier: Apache-2.0
"""Remove what a killed process left half made in the shared memory of Fast DDS."""

import time
from contextlib import suppress
from pathlib import Path

SHARED_MEMORY = Path('/dev/shm')  # noqa: S108 - where Fast DDS keeps its segments
# Fast DDS gives the segment of a port its size within microseconds of making its file.
TORN_AFTER_S = 0.5


def remove_torn_ports(folder: Path = SHARED_MEMORY) -> None:
    """Remove the segments of ports in `folder` that were made but never given a size.

    A process that is killed between the two leaves an empty file, and every participant of every
    domain that opens the port afterwards waits for its size for ever. Only where there is an empty
    file is `TORN_AFTER_S` awaited, in which its maker can give it a size.
    """
    empty = [segment for segment in folder.glob('fastrtps_port*') if _is_empty(segment)]
    if not empty:
        return
    time.sleep(TORN_AFTER_S)
    for segment in filter(_is_empty, empty):
        # Another process may remove it first, or own it.
        with suppress(OSError):
            segment.unlink()


def _is_empty(segment: Path) -> bool:
    """Return whether the file has no size; the files of locks never have one."""
    try:
        return not segment.name.endswith('_el') and segment.stat().st_size == 0
    except OSError:
        return False
