# SPDX-License-Identifier: Apache-2.0
"""Failures of the simulation that a caller may want to treat."""


class SimError(Exception):
    """Base of all failures of this package."""


class CommandRefusedError(SimError):
    """A vehicle will not do what it was told; the text says why."""


class JournalError(SimError):
    """A journal cannot be read back."""
