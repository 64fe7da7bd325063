# SPDX-License-Identifier: Apache-2.0
"""When the evidence is enough: Wald's sequential probability ratio test for each source."""

import math
from dataclasses import dataclass

from rocsafe_radiation.localization import Localization

CONTINUE, PRESENT, ABSENT = 'continue', 'present', 'absent'


@dataclass(frozen=True, slots=True, kw_only=True)
class StoppingRule:
    """Error rates and precision at which a search may end.

    Wald (1945): decide for a source when the likelihood ratio exceeds (1 - missed) / false_alarm,
    against it below missed / (1 - false_alarm); in between, measure on. The rates hold for any
    number of looks at the data, which a test of fixed size does not allow.

    Attributes
    ----------
    false_alarm: probability of deciding for a source that is not there.
    missed: probability of deciding against one that is there.
    ellipse_95_m: longest half axis of a source's 95 % ellipse that is precise enough.
    """

    false_alarm: float = 0.01
    missed: float = 0.01
    ellipse_95_m: float = 5.0

    def __post_init__(self) -> None:
        for name in ('false_alarm', 'missed'):
            if not 0.0 < getattr(self, name) < 0.5:
                raise ValueError(f'{name} = {getattr(self, name)} must be between 0 and 0.5')
        if not 0.0 < self.ellipse_95_m < math.inf:
            raise ValueError(f'ellipse_95_m = {self.ellipse_95_m} must be above 0 and finite')

    def decision(self, log_ratio: float) -> str:
        """Return ``present``, ``absent`` or ``continue`` for a logarithm of a likelihood ratio."""
        if log_ratio >= math.log((1.0 - self.missed) / self.false_alarm):
            return PRESENT
        if log_ratio <= math.log(self.missed / (1.0 - self.false_alarm)):
            return ABSENT
        return CONTINUE

    def is_enough(self, found: Localization) -> bool:
        """Return whether the number of sources is decided and each is placed well enough.

        The ratio is that of the number found to its best rival, from their probabilities.
        """
        chances = sorted(found.order_probabilities, reverse=True)
        rival = chances[1] if len(chances) > 1 else 0.0
        log_ratio = math.log(max(chances[0], 1e-300)) - math.log(max(rival, 1e-300))
        placed = all(source.ellipse_95()[0] <= self.ellipse_95_m for source in found.sources)
        return placed and self.decision(log_ratio) == PRESENT
