# SPDX-License-Identifier: Apache-2.0
"""Errors of the fleet."""


class FleetError(Exception):
    """Base of the errors of this package."""


class PacketError(FleetError):
    """A packet is damaged, or of another fleet."""


class LinkError(FleetError):
    """The link to other agents cannot be opened."""
