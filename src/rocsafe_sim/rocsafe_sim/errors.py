# SPDX-License-Identifier: Apache-2.0
"""Errors of the simulation that callers handle."""


class SimError(Exception):
    """Base of all errors of this package."""


class CommandRefusedError(SimError):
    """A vehicle refuses a command; the text states why."""


class JournalError(SimError):
    """A journal cannot be read back."""
