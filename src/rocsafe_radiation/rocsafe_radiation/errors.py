# SPDX-License-Identifier: Apache-2.0
"""Errors of this package."""


class RadiationError(Exception):
    """Base of all errors of this package."""


class UnknownPointError(RadiationError):
    """A dose rate is asked for at a place that is not finite or out of range."""


class DetectorLostError(RadiationError):
    """The port of a detector was tried as often as allowed."""


class TooFewReadingsError(RadiationError):
    """There are too few readings to localise sources."""
