# SPDX-License-Identifier: Apache-2.0
"""When the evidence is enough: Wald's sequential test, and the size of the ellipses."""

import math
from dataclasses import dataclass

from rocsafe_hazard.next_places import Verdict
from rocsafe_radiation.decision.sequential_decision import SequentialEvidence
from rocsafe_radiation.localization.estimates import SPREAD, Localization

CONTINUE, PRESENT, ABSENT = 'continue', 'present', 'absent'


@dataclass(frozen=True, slots=True, kw_only=True)
class StoppingRule:
    """Error rates and precision at which a search may end.

    Wald (1945): decide for a source when the likelihood ratio exceeds (1 - missed) / false_alarm,
    and against it below missed / (1 - false_alarm); in between, continue to measure. The rates
    hold for any number of looks at the data, which a test of fixed size does not allow.

    Attributes
    ----------
    false_alarm
        Probability of deciding for a source that is not there.
    missed
        Probability of deciding against one that is there.
    ellipse_95_m
        Longest half axis of a source's 95 % ellipse that is precise enough.
    smallest_usvh
        Dose rate at 1 m of the weakest source that matters: 1 GBq of Cs-137.
    """

    false_alarm: float = 0.01
    missed: float = 0.01
    ellipse_95_m: float = 5.0
    smallest_usvh: float = 92.0

    def __post_init__(self) -> None:
        for name in ('false_alarm', 'missed'):
            if not 0.0 < getattr(self, name) < 0.5:
                raise ValueError(f'{name} = {getattr(self, name)} must be between 0 and 0.5')
        for name in ('ellipse_95_m', 'smallest_usvh'):
            if not 0.0 < getattr(self, name) < math.inf:
                raise ValueError(f'{name} = {getattr(self, name)} must be above 0 and finite')

    def decision(self, evidence: SequentialEvidence) -> str:
        """Return ``present``, ``absent`` or ``continue``."""
        if evidence.log_ratio >= self._upper:
            return PRESENT
        if evidence.log_ratio_smallest <= math.log(self.missed / (1.0 - self.false_alarm)):
            return ABSENT
        return CONTINUE

    def verdict(self, found: Localization, evidence: SequentialEvidence) -> Verdict:
        """Return whether the number of sources is decided and each is placed well enough."""
        if found.caveats:
            return Verdict(is_enough=False, reason=found.caveats[0])
        if not found.is_understood:
            return Verdict(
                is_enough=False, reason='sources and background do not explain the readings'
            )
        if found.is_lopsided:
            return Verdict(
                is_enough=False,
                reason='something beside the sources may take part of their dose rate',
            )
        if found.may_be_spread:
            return Verdict(is_enough=False, reason=SPREAD)
        if not found.sources:
            return self._verdict_of_none(evidence)
        ratio = _log_ratio_to_rival(found.order_probabilities)
        count = len(found.sources)
        what = f'{count} source{"s" if count > 1 else ""}'
        if ratio < self._upper:
            return Verdict(is_enough=False, reason=f'{what} found, but the number is not decided')
        widest = max(source.ellipse_95()[0] for source in found.sources)
        # A width is never stated as 0.0 m.
        within = f'placed within {max(widest, 0.1):.1f} m (95 %)'
        if widest > self.ellipse_95_m:
            limit = f'{self.ellipse_95_m:g} m are wanted'
            return Verdict(is_enough=False, reason=f'{what}, {within}: {limit}')
        return Verdict(is_enough=True, reason=f'{what}, {within}')

    @property
    def _upper(self) -> float:
        return math.log((1.0 - self.missed) / self.false_alarm)

    def _verdict_of_none(self, evidence: SequentialEvidence) -> Verdict:
        weakest = f'{self.smallest_usvh:g} uSv/h at 1 m'
        decision = self.decision(evidence)
        if decision == ABSENT:
            return Verdict(is_enough=True, reason=f'no source of {weakest} or more')
        if decision == PRESENT:
            return Verdict(is_enough=False, reason='more than background, but no source placed')
        return Verdict(is_enough=False, reason=f'a source of {weakest} may still be hidden')


def _log_ratio_to_rival(probabilities: tuple[float, ...]) -> float:
    """Return the logarithm of the best probability over the second best."""
    chances = [*sorted(probabilities, reverse=True), 0.0]
    return math.log(max(chances[0], 1e-300)) - math.log(max(chances[1], 1e-300))
