# SPDX-License-Identifier: Apache-2.0
"""Choices of ways along an order of points, of which no other is better in everything."""

from collections.abc import Sequence
from dataclasses import dataclass

from rocsafe_ground.route.constrained import ROUNDING
from rocsafe_ground.route.edges import GridPath

# More partial choices are thinned out: the fastest and the cleanest stay.
MOST_CHOICES = 1000

Legs = tuple[GridPath, ...]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Choice:
    """A way for each leg so far, and what they cost together; the last leg has the others."""

    time_s: float
    dose_usv: float
    load: float
    way: GridPath | None = None
    before: 'Choice | None' = None

    @property
    def costs(self) -> tuple[float, float, float]:
        """Time, dose and load."""
        return self.time_s, self.dose_usv, self.load

    @property
    def legs(self) -> Legs:
        """The ways, the first one first."""
        found, here = [], self
        while here.way is not None and here.before is not None:
            found.append(here.way)
            here = here.before
        return tuple(reversed(found))

    def longer(self, way: GridPath) -> 'Choice':
        """Return it with another way."""
        return Choice(
            time_s=self.time_s + way.time_s, dose_usv=self.dose_usv + way.dose_usv,
            load=self.load + way.load, way=way, before=self,
        )  # fmt: skip


def joined(options: Sequence[Sequence[GridPath]], room: tuple[float, float]) -> list[Choice]:
    """Return choices of a way for each leg within the room for dose and load, the fastest first.

    Choices that another is no worse than in time, dose and load are dropped.
    """
    dose, load = (limit * (1.0 + ROUNDING) for limit in room)
    choices = [Choice(time_s=0.0, dose_usv=0.0, load=0.0)]
    for ways in options:
        longer = [choice.longer(way) for choice in choices for way in ways]
        choices = _thinned(
            _undominated([one for one in longer if one.dose_usv <= dose and one.load <= load])
        )
    return choices


def _undominated(choices: list[Choice]) -> list[Choice]:
    kept: list[Choice] = []
    front: list[tuple[float, float]] = []
    for choice in sorted(choices, key=lambda one: one.costs):
        dose, load = choice.dose_usv, choice.load
        if any(d <= dose and x <= load for d, x in front):
            continue
        kept.append(choice)
        front = [(d, x) for d, x in front if d < dose or x < load]
        front.append((dose, load))
    return kept


def _thinned(choices: list[Choice]) -> list[Choice]:
    """Return at most `MOST_CHOICES`, evenly spaced, first and last among them."""
    count = len(choices)
    if count <= MOST_CHOICES:
        return choices
    return [choices[round(k * (count - 1) / (MOST_CHOICES - 1))] for k in range(MOST_CHOICES)]
