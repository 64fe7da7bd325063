# SPDX-License-Identifier: Apache-2.0
"""Values on the command line, with their limits."""

import re
from argparse import ArgumentTypeError


def positive_int(text: str) -> int:
    """Return a whole number above zero."""
    return _whole(text, 1, 'value must be a positive integer')


def unsigned_int(text: str) -> int:
    """Return a whole number, zero or more."""
    return _whole(text, 0, 'value must be non-negative integer')


def positive_float(text: str) -> float:
    """Return a number above zero."""
    try:
        value = float(text)
    except ValueError:
        raise ArgumentTypeError('Expects a floating point number') from None
    if not value > 0.0:
        raise ArgumentTypeError('Value must be positive')
    return value


def regular_expression(text: str) -> re.Pattern[str]:
    """Return the expression, compiled."""
    try:
        return re.compile(text)
    except re.error as error:
        raise ArgumentTypeError(f"not a regular expression: '{text}': {error}") from error


def _whole(text: str, lowest: int, complaint: str) -> int:
    """Return a whole number that is not below `lowest`."""
    try:
        value = int(text)
    except ValueError:
        raise ArgumentTypeError(complaint) from None
    if value < lowest:
        raise ArgumentTypeError(complaint)
    return value
