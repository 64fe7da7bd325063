# SPDX-License-Identifier: Apache-2.0
"""What a command is: words, arguments and a function; and how it fails."""

from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from dataclasses import dataclass

AddArguments = Callable[[ArgumentParser], None]
Run = Callable[[Namespace], int]


class CommandError(Exception):
    """The command cannot do what was asked; the text is what the user reads."""


def add_nothing(parser: ArgumentParser) -> None:
    """Leave the parser as it is: for verbs without arguments."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verb:
    """One verb of a command, such as `echo` of `topic`."""

    name: str
    summary: str
    run: Run
    add_arguments: AddArguments = add_nothing


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """One command, such as `topic`: either a row of verbs, or one action of its own."""

    verbs: tuple[Verb, ...] = ()
    run: Run | None = None
    add_arguments: AddArguments = add_nothing
