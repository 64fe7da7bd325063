# SPDX-License-Identifier: Apache-2.0
"""Checks of values that raise ValueError with name, value and limit in one wording."""

import math


def require_finite(name: str, value: float, unit: str = '') -> float:
    """Return `value` as a float; raise ValueError unless it is a finite number."""
    number = _number(name, value)
    if not math.isfinite(number):
        raise ValueError(f'{name} is {number:g}: must be a finite number{_of(unit)}')
    return number


def require_positive(name: str, value: float, unit: str = '') -> float:
    """Return `value` as a float; raise ValueError unless it is finite and above zero."""
    number = require_finite(name, value, unit)
    if number <= 0.0:
        raise ValueError(f'{name} is {number:g}{_after(unit)}: must be above 0')
    return number


def require_not_negative(name: str, value: float, unit: str = '') -> float:
    """Return `value` as a float; raise ValueError unless it is finite and at least zero."""
    number = require_finite(name, value, unit)
    if number < 0.0:
        raise ValueError(f'{name} is {number:g}{_after(unit)}: must be 0 or above')
    return number


def require_between(name: str, value: float, low: float, high: float, unit: str = '') -> float:
    """Return `value` as a float; raise ValueError unless low <= value <= high."""
    number = require_finite(name, value, unit)
    if not low <= number <= high:
        limits = f'{low:g} to {high:g}{_after(unit)}'
        raise ValueError(f'{name} is {number:.12g}{_after(unit)}: must be {limits}')
    return number


def require_count(name: str, value: int, low: int, high: int) -> int:
    """Return `value` as an int; raise ValueError unless it is whole and low <= value <= high."""
    number = require_between(name, value, low, high)
    if number != int(number):
        raise ValueError(f'{name} is {number:g}: must be a whole number')
    return int(number)


def _number(name: str, value: float) -> float:
    """Return `value` as a float, refusing what is not a number (a bool or a text is none)."""
    if isinstance(value, bool | str):
        raise ValueError(f'{name} is {value!r}: must be a number')  # noqa: TRY004 (one error type)
    try:
        return float(value)
    except (TypeError, ValueError) as error:
        raise ValueError(f'{name} is {value!r}: must be a number') from error


def _of(unit: str) -> str:
    return f' of {unit}' if unit else ''


def _after(unit: str) -> str:
    return f' {unit}' if unit else ''
