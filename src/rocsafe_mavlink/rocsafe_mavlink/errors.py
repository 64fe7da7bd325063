# SPDX-License-Identifier: Apache-2.0
"""Errors of this package, as far as callers treat them differently."""


class MavlinkError(Exception):
    """Base of all errors of this package."""


class EndpointError(MavlinkError):
    """The address of a link cannot be understood or opened."""


class KeyFileError(MavlinkError):
    """A signing key cannot be read, or others could read it too."""


class NotAllowedError(MavlinkError):
    """A message or command is not among those that may be sent."""


class CommandRefusedError(MavlinkError):
    """A command of the operator cannot be given now."""


class WaitError(MavlinkError):
    """It is not known yet whether a route may be flown: ask again."""
