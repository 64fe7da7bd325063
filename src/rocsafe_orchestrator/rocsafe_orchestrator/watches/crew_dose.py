# SPDX-License-Identifier: Apache-2.0
"""Expected doses of the people of a mission, and their warnings.

The dose rate where somebody stands follows from the estimated sources by the inverse square law.
It replaces no dosimeter.
"""

from collections.abc import Iterable
from dataclasses import dataclass

from rocsafe_geo.limits import require_positive

S_PER_H = 3600.0
# Share of a dose budget at which a person is warned to prepare for relief.
WARNING_SHARE = 0.8
# Below this distance, metres, an estimate of a source does not give the dose rate.
LEAST_DISTANCE_M = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class CrewMember:
    """A person at a place, with the largest dose allowed, microsievert."""

    name: str
    budget_usv: float

    def __post_init__(self) -> None:
        require_positive('budget_usv', self.budget_usv)


class CrewDose:
    """Adds up the expected dose of one person.

    Attributes
    ----------
    dose_usv
        Expected dose so far, microsievert.
    """

    def __init__(self, member: CrewMember) -> None:
        self.member = member
        self.dose_usv = 0.0
        self._warned_share = 0.0
        self._time_s: float | None = None

    def advance(self, time_s: float, dose_rate_usvh: float) -> str:
        """Add the dose since the last call, and return the warning; empty: none.

        Parameters
        ----------
        time_s
            Time of the mission, seconds; one that is not later adds nothing.
        dose_rate_usvh
            Dose rate at the place of the person since then, microsievert per hour.
        """
        last_s, self._time_s = self._time_s, max(time_s, self._time_s or 0.0)
        if last_s is None or time_s <= last_s:
            return ''
        self.dose_usv += dose_rate_usvh * (time_s - last_s) / S_PER_H
        share = self.dose_usv / self.member.budget_usv
        reached = max((s for s in (WARNING_SHARE, 1.0) if share >= s), default=0.0)
        if reached <= self._warned_share:
            return ''
        self._warned_share = reached
        what = 'must leave' if reached >= 1.0 else 'is to be relieved soon'
        return (
            f'{self.member.name} {what}: expected dose {self.dose_usv:.3g} uSv of '
            f'{self.member.budget_usv:.3g} uSv'
        )


def dose_rate_usvh(sources: Iterable[tuple[float, float]]) -> float:
    """Return the dose rate of sources, each given by its distance (m) and rate at 1 m."""
    return sum(rate / max(distance, LEAST_DISTANCE_M) ** 2 for distance, rate in sources)
