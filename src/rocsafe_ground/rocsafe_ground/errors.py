# SPDX-License-Identifier: Apache-2.0
"""Why a valid request has no route. A malformed request is a ValueError."""


class GroundError(Exception):
    """Base of what a caller may want to tell apart; the text is one line for a person."""


class NoMapError(GroundError):
    """The products of a mission lack what a route needs."""


class NoWayError(GroundError):
    """A place cannot be driven to."""


class BeyondBudgetError(GroundError):
    """No route is within the budgets; the text names the least budget that would do."""
