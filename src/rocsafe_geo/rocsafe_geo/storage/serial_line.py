# SPDX-License-Identifier: Apache-2.0
"""Serial ports, opened for bytes as they come."""

import os
import termios
import tty


def open_serial(device: str, baud: int, access: int) -> int:
    """Return the descriptor of a serial port that does not block.

    Parameters
    ----------
    device
        Path of the port.
    baud
        One of the rates that the system knows.
    access
        ``os.O_RDONLY`` or ``os.O_RDWR``.

    Raises
    ------
    OSError
        If it cannot be opened.
    """
    descriptor = os.open(device, access | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        tty.setraw(descriptor)
        settings = termios.tcgetattr(descriptor)
        settings[4] = settings[5] = getattr(termios, f'B{baud}')
        termios.tcsetattr(descriptor, termios.TCSANOW, settings)
    except termios.error as error:
        os.close(descriptor)
        raise OSError(*error.args) from error
    return descriptor


def is_baud(number: int) -> bool:
    """Return whether the system knows a rate."""
    return hasattr(termios, f'B{number}')
