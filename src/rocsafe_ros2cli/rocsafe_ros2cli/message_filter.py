# SPDX-License-Identifier: Apache-2.0
"""`--filter`: a Python expression of `m`, the message, that says whether it counts."""

from argparse import ArgumentParser, ArgumentTypeError
from types import CodeType
from typing import Any

from rocsafe_ros2cli.command import CommandError


def add_filter_argument(parser: ArgumentParser) -> None:
    """Add `--filter`."""
    parser.add_argument(
        '--filter',
        dest='condition',
        metavar='EXPR',
        type=python_expression,
        help='Only messages for which this Python expression of m, the message, is true',
    )


def python_expression(text: str) -> CodeType:
    """Return the expression, compiled."""
    try:
        return compile(text, text, 'eval')
    except (SyntaxError, ValueError) as error:
        raise ArgumentTypeError(f"not a Python expression: '{text}'") from error


def passes(condition: CodeType | None, message: Any) -> bool:
    """Return whether a message counts; all do without a condition.

    Raises
    ------
    CommandError
        If the expression does not fit the message.
    """
    if condition is None:
        return True
    try:
        # The user's own expression on the user's own machine, as the real command takes it.
        return bool(eval(condition, {'m': message}))  # noqa: S307
    except Exception as error:
        raise CommandError(f"Cannot evaluate '{condition.co_filename}': {error}") from error
