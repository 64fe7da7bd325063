# SPDX-License-Identifier: Apache-2.0
"""Readers of numbers on a command line: the argument ``type`` of `argparse`."""

import argparse
import math
from collections.abc import Callable


def number(low: float, high: float, unit: str = '') -> Callable[[str], float]:
    """Return a reader of a number within limits; its error names value and limits.

    Parameters
    ----------
    low, high
        Limits, both allowed.
    unit
        Unit with a blank before it, for the error.

    Examples
    --------
    >>> number(0.0, 1.0)('0.25')
    0.25
    """

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f'{text}: must be within {low:g} to {high:g}{unit}')
        return value

    return read


def whole_number(low: int, high: int) -> Callable[[str], int]:
    """Return a reader of a whole number within limits; its error names value and limits."""

    def read(text: str) -> int:
        if not text.isascii() or not text.isdigit() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(f'{text}: must be a whole number, {low} to {high}')
        return int(text)

    return read
