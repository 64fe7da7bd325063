# SPDX-License-Identifier: Apache-2.0
"""Readers of numbers and sizes on a command line: the argument ``type`` of `argparse`."""

import argparse
import math
from collections.abc import Callable

SMALLEST_SIDE_PX, LARGEST_SIDE_PX = 16, 8192


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


def image_size(text: str) -> tuple[int, int]:
    """Return width and height in pixels of ``WxH``; its error names what it must be.

    Examples
    --------
    >>> image_size('1280x800')
    (1280, 800)
    """
    try:
        width, height = (int(part) for part in text.lower().split('x'))
    except ValueError:
        raise argparse.ArgumentTypeError(f'{text}: must be WxH, for instance 1280x800') from None
    if not all(SMALLEST_SIDE_PX <= side <= LARGEST_SIDE_PX for side in (width, height)):
        raise argparse.ArgumentTypeError(
            f'{text}: sides must be within {SMALLEST_SIDE_PX} to {LARGEST_SIDE_PX} px'
        )
    return width, height
