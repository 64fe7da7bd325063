# SPDX-License-Identifier: Apache-2.0
"""Standard streams of a process that was started without them, as by a service manager."""

import os
import sys
from contextlib import suppress
from pathlib import Path


def open_standard_streams() -> None:
    """Open the null device for each standard stream that is closed.

    Else the next file or socket has its number, and libraries fail for want of `sys.stderr`.
    """
    for number in range(3):
        with suppress(OSError):
            os.fstat(number)
            continue
        os.open(os.devnull, os.O_RDWR)
    nowhere = Path(os.devnull).open('w', encoding='utf-8')  # noqa: SIM115 - stays open
    sys.stdout, sys.stderr = sys.stdout or nowhere, sys.stderr or nowhere
