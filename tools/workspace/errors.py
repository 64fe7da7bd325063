# SPDX-License-Identifier: Apache-2.0
"""Errors and signals that end a set-up early."""


class SetupError(Exception):
    """An error that the user has to correct; its text is the one line that is shown."""


class CommandError(SetupError):
    """A command of a stage failed; `log_text` is its whole output."""

    def __init__(self, message: str, log_text: str) -> None:
        super().__init__(message)
        self.log_text = log_text


class Interrupted(BaseException):
    """A signal asked the set-up to stop; like KeyboardInterrupt it is no error."""

    def __init__(self, signal_number: int) -> None:
        super().__init__(signal_number)
        self.exit_code = 128 + signal_number
