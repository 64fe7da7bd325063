# SPDX-License-Identifier: Apache-2.0
"""What can go wrong in radiation, as its callers would tell it apart."""


class RadiationError(Exception):
    """Base of all errors of this package."""


class UnknownPointError(RadiationError):
    """A dose rate is asked for at a place that is not a place."""
