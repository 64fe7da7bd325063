# SPDX-License-Identifier: Apache-2.0
"""When a ground vehicle gives up its route: decided on its own readings, in time to come home."""

from dataclasses import dataclass

from rocsafe_geo.limits import require_between
from rocsafe_geo.motion.dose_reserve import DoseOutlook, ReserveOptions, dose_reason
from rocsafe_sim.driving.drive_state import DriveOutcome


@dataclass(frozen=True, slots=True, kw_only=True)
class CautionOptions(ReserveOptions):
    """How early it turns back, and which readings are not those that were planned with.

    Attributes
    ----------
    least_ratio
        Readings below this times the prediction.
    silent_s
        Time without a reading after which it comes back.
    """

    least_ratio: float = 0.5
    silent_s: float = 15.0

    def __post_init__(self) -> None:
        # Not super(): with slots the class is made a second time.
        ReserveOptions.__post_init__(self)
        require_between('least_ratio', self.least_ratio, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outlook(DoseOutlook):
    """What a drive has taken of dose and charge, and what it would still take.

    Attributes
    ----------
    predicted_line_usv
        For the way up to the end of the present line and stand.
    rest_j, back_j, charge_j
        Energy of both ways, and what is left without the reserve.
    is_at_stop
        Whether a line and its stand have just been completed.
    """

    predicted_line_usv: float
    rest_j: float
    back_j: float
    charge_j: float
    is_at_stop: bool


def reason_to_end(outlook: Outlook, options: CautionOptions) -> tuple[DriveOutcome, str] | None:
    """Return why a drive must not go on as planned, None if it may."""
    if text := dose_reason(outlook, options):
        return DriveOutcome.TURNED_BACK_DOSE, text
    must_save_charge = outlook.back_j * options.doubt >= outlook.charge_j
    if must_save_charge and outlook.rest_j * options.doubt > outlook.charge_j:
        return DriveOutcome.BATTERY_LOW, 'the charge is needed for the way back'
    return _surprise(outlook, options)


def _surprise(outlook: Outlook, options: CautionOptions) -> tuple[DriveOutcome, str] | None:
    """Return that readings are not those predicted; more is noticed before the line ends."""
    least = options.least_share * outlook.budget_usv
    taken, low, high = outlook.dose_usv, outlook.predicted_usv, outlook.predicted_line_usv
    is_more = taken > max(least, options.largest_ratio * max(low, high))
    is_less = outlook.is_at_stop and max(least, taken) < options.least_ratio * low
    if not (is_more or is_less):
        return None
    predicted = max(low, high) if is_more else low
    text = f'it took {taken:.4g} uSv where {predicted:.4g} were predicted'
    return DriveOutcome.DOSE_UNEXPECTED, text
