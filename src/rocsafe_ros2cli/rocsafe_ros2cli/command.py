# SPDX-License-Identifier: Apache-2.0
"""Verbs of the command line: their arguments and functions, and how they fail."""

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Argument = Callable[[ArgumentParser], object]
"""Adds one argument to a parser."""


class CommandError(Exception):
    """The command cannot do what was asked; the text is what the user reads."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verb:
    """One verb of a command, such as `echo` of `topic`.

    Attributes
    ----------
    run
        Does the work; raises `CommandError` if that fails.
    """

    name: str
    summary: str
    run: Callable[[Namespace], None]
    arguments: tuple[Argument, ...] = ()


def argument(*names: str, **options: Any) -> Argument:
    """Return what adds an argument to a parser; parameters as `ArgumentParser.add_argument`."""
    return lambda parser: parser.add_argument(*names, **options)


def flag(*names: str, text: str) -> Argument:
    """Return what adds an option without a value to a parser."""
    return argument(*names, action='store_true', help=text)


def positive_int(text: str) -> int:
    """Return a whole number above zero."""
    return int(_positive(text, int, 'value must be a positive integer'))


def positive_float(text: str) -> float:
    """Return a number above zero."""
    return float(_positive(text, float, 'Value must be positive'))


def _positive(text: str, kind: Any, complaint: str) -> Any:
    try:
        value = kind(text)
    except ValueError:
        value = 0
    if not value > 0:
        raise ArgumentTypeError(complaint)
    return value
