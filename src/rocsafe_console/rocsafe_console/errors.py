# SPDX-License-Identifier: Apache-2.0
"""Errors of the console."""


class ConsoleError(Exception):
    """The console cannot do what was asked; the text is for people."""


class RefusedError(ConsoleError):
    """A request is refused: it names who may not, or what has changed."""


class TooManyError(RefusedError):
    """Somebody asks faster than a person can."""
