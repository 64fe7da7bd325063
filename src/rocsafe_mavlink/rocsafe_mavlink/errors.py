# SPDX-License-Identifier: Apache-2.0
"""What can go wrong with a link to an autopilot, as its callers would tell it apart."""


class MavlinkError(Exception):
    """Base of all errors of this package."""


class EndpointError(MavlinkError):
    """An address of a link is not one, or cannot be opened."""


class KeyFileError(MavlinkError):
    """A signing key cannot be read, or others could read it too."""


class NotAllowedError(MavlinkError):
    """A message or command is not among those that may be sent."""


class CommandRefusedError(MavlinkError):
    """An operator's order cannot be given now."""


class WaitError(MavlinkError):
    """It cannot be said yet whether a route may be flown: ask again."""
