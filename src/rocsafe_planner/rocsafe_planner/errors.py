# SPDX-License-Identifier: Apache-2.0
"""Why a valid request has no plan. A malformed request is a ValueError."""


class PlannerError(Exception):
    """Base of what a caller may want to tell apart; the text is one line for a person."""


class TooManyViewpointsError(PlannerError):
    """The region needs more viewpoints than the limit."""


class BeyondEnduranceError(PlannerError):
    """A vehicle's route takes longer than its battery lasts."""


class NoFreeHeightError(PlannerError):
    """No flight height is free of unheard vehicles."""


class PlanningCancelledError(PlannerError):
    """The caller asked to stop."""


class NoWayError(PlannerError):
    """Exclusions leave no way to a place, or no viewpoint at all."""


class MissingSensorError(PlannerError):
    """No vehicle carries what a viewpoint requires."""


class NothingLeftError(PlannerError):
    """Every viewpoint is photographed."""


class FaultyPlanError(PlannerError):
    """The independent checker found a fault in a plan: it is not published."""
