# SPDX-License-Identifier: Apache-2.0
"""When a ground vehicle must come home to keep its budget of dose, by its own readings."""

from dataclasses import dataclass

from rocsafe_geo.limits import require_between, require_not_negative


@dataclass(frozen=True, slots=True, kw_only=True)
class ReserveOptions:
    """How early it turns back.

    Attributes
    ----------
    reserve_fraction
        Part of the budget of dose that is never planned to be used.
    reaction_s
        Time for which the newest dose rate is taken to go on before a decision has effect: two
        windows of a detector, braking, and speeding up on the way back.
    doubt
        What the way back may take more than on the way there, and at the start the rest of the
        route more than predicted; less of it the more of the prediction is behind.
    largest_ratio
        Readings above this times the prediction are not those that were planned with.
    least_share
        Part of the budget below which doses are not compared: counting noise.
    """

    reserve_fraction: float = 0.02
    reaction_s: float = 6.0
    doubt: float = 1.25
    largest_ratio: float = 2.0
    least_share: float = 0.05

    def __post_init__(self) -> None:
        require_between('reserve_fraction', self.reserve_fraction, 0.0, 0.9)
        require_not_negative('reaction_s', self.reaction_s, 's')
        require_between('doubt', self.doubt, 1.0, 10.0)
        require_between('largest_ratio', self.largest_ratio, 1.0, 1e3)


@dataclass(frozen=True, slots=True, kw_only=True)
class DoseOutlook:
    """What a drive has taken of its budget, and what it would still take.

    Attributes
    ----------
    budget_usv, turn_back_usvh
        Limits of the route.
    dose_usv, rate_usvh
        Taken so far, and read last.
    growth
        Ratio of the last reading to that of some seconds ago.
    predicted_usv
        For the way so far.
    rest_usv
        Predicted for the rest of the route.
    is_rest_hotter
        Whether a line of the rest has much higher dose rates than those that were measured: the
        measured share of the prediction does not tell of them.
    hotter_ratio
        How many times the prediction such a rest may take, with 95 % confidence; 0: nobody told.
    back_usv
        Measured for the way back on its own tracks.
    """

    budget_usv: float
    turn_back_usvh: float
    dose_usv: float
    rate_usvh: float
    growth: float
    predicted_usv: float
    rest_usv: float
    is_rest_hotter: bool
    hotter_ratio: float
    back_usv: float


def dose_reason(outlook: DoseOutlook, options: ReserveOptions) -> str:
    """Return why a vehicle must come home, empty if it need not.

    It turns back at the last moment at which the way back, as measured, still fits into the
    budget, unless the rest of the route fits, by the measured share of the prediction.
    """
    level, growth = outlook.turn_back_usvh, _growth(outlook, options)
    # It still goes some way towards the source before it stops.
    if outlook.rate_usvh * growth >= level:
        rising = f', {growth:.2g} times as much as just before' if growth > 1.0 else ''
        return f'it reads {outlook.rate_usvh:.4g} uSv/h{rising}: the level is {level:.4g}'
    if _must_save_dose(outlook, options):
        return f'{outlook.dose_usv:.4g} of {outlook.budget_usv:.4g} uSv are used'
    return ''


def _growth(outlook: DoseOutlook, options: ReserveOptions) -> float:
    return min(max(outlook.growth, 1.0), options.largest_ratio)


def _must_save_dose(outlook: DoseOutlook, options: ReserveOptions) -> bool:
    limit = outlook.budget_usv * (1.0 - options.reserve_fraction)
    soon = outlook.rate_usvh * _growth(outlook, options) * options.reaction_s / 3600.0
    if outlook.dose_usv + soon + outlook.back_usv * options.doubt < limit:
        return False
    # Small doses tell nothing of the prediction: they count as if so much had gone as predicted.
    known = options.least_share * outlook.budget_usv
    share = max(1.0, (outlook.dose_usv + known) / (outlook.predicted_usv + known))
    # What is wrong with a prediction is mostly the same along the whole way, such as the strength
    # of a source: the measured share tells it the better the more of the way is behind.
    ahead = outlook.rest_usv / max(outlook.rest_usv + outlook.predicted_usv, 1e-9)
    own = 1.0 + (options.doubt - 1.0) * ahead
    doubt = own
    if outlook.is_rest_hotter:
        told = outlook.hotter_ratio or options.largest_ratio
        doubt = min(max(own, told), options.largest_ratio)
    rest = outlook.rest_usv * share * doubt
    # Stopping and leaving a hot place takes a dose of its own.
    back = outlook.back_usv + soon
    return outlook.dose_usv + rest > limit and back < rest
