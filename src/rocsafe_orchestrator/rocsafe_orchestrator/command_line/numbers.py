# SPDX-License-Identifier: Apache-2.0
"""Numbers on the command line, within their limits."""

import argparse
import math

from rocsafe_planner.plan.survey_options import MAX_VIEWPOINTS_LIMIT
from rocsafe_scenario.limits import (
    LARGEST_BUDGET_S,
    LARGEST_FLEET,
    LARGEST_HEIGHT_M,
    LARGEST_SEED,
    LARGEST_SPEED,
)

LARGEST_PATIENCE_S = 300.0


def speed(text: str) -> float:
    """Return a factor of real time; an error names value and limits."""
    return _number(text, 0.0, LARGEST_SPEED, ' simulated seconds a second')


def height(text: str) -> float:
    """Return a height in metres; an error names value and limits."""
    return _number(text, 1.0, LARGEST_HEIGHT_M, ' m')


def budget(text: str) -> float:
    """Return a time in seconds; an error names value and limits."""
    return _number(text, 0.0, LARGEST_BUDGET_S, ' s')


def metres(text: str) -> float:
    """Return a distance in metres; an error names value and limits."""
    return _number(text, 0.0, 10_000.0, ' m')


def seconds(text: str) -> float:
    """Return a time of up to a day in seconds; an error names value and limits."""
    return _number(text, 0.0, 86_400.0, ' s')


def overlap(text: str) -> float:
    """Return an overlap; an error names value and limits."""
    return _number(text, 0.0, 0.95, '')


def part(text: str) -> float:
    """Return a part of a whole, 0 to 1."""
    return _number(text, 0.0, 1.0, '')


def vehicle_speed(text: str) -> float:
    """Return a speed of a vehicle; an error names value and limits."""
    return _number(text, 0.1, 100.0, ' m/s')


def wind(text: str) -> float:
    """Return a component of the wind; an error names value and limits."""
    return _number(text, -100.0, 100.0, ' m/s')


def seed(text: str) -> int:
    """Return a seed; an error names value and limits."""
    return _whole(text, 0, LARGEST_SEED)


def count(text: str) -> int:
    """Return a number of vehicles; an error names value and limits."""
    return _whole(text, 1, LARGEST_FLEET)


def viewpoint_count(text: str) -> int:
    """Return a number of viewpoints; an error names value and limits."""
    return _whole(text, 1, MAX_VIEWPOINTS_LIMIT)


def waiting_time(text: str) -> float:
    """Return a time to wait in seconds; an error names value and limits."""
    return _number(text, 0.0, LARGEST_PATIENCE_S, ' s')


def _number(text: str, low: float, high: float, unit: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise argparse.ArgumentTypeError(f'{text}: must be within {low:g} to {high:g}{unit}')
    return value


def _whole(text: str, low: int, high: int) -> int:
    if not text.isascii() or not text.isdigit() or not low <= int(text) <= high:
        raise argparse.ArgumentTypeError(f'{text}: must be a whole number, {low} to {high}')
    return int(text)
