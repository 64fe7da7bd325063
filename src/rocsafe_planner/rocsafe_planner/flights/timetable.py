# SPDX-License-Identifier: Apache-2.0
"""When each of several vehicles starts, and which of its flights it flies, so that all keep apart.

One vehicle after another is given the flights with which it lands earliest, clear of those before
it. The order decides: first the vehicle that flies longest. A better timetable is sought by
looking at the last one from its end, where all start as late as they can, and then from its begin
again (double justification: Valls, Ballestin & Quintanilla 2005, doi:10.1016/j.ejor.2004.04.008),
by beginning with the vehicle that flies shortest, and by giving whoever lands last another turn.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import IndexArray
from rocsafe_planner.flights.flight_choice import FlightChoice
from rocsafe_planner.flights.flight_track import FlightTrack
from rocsafe_planner.flights.separation import Conflicts, box_distances

LONGEST_HOVER_S = 300
"""Nobody hovers longer to let others pass."""
MOST_TRIES, MOST_TURNS = 60, 2000
"""Timetables that are tried for a better one, and vehicles in all of them together."""

Choices = Mapping[int, Iterable[FlightChoice]]
"""What each vehicle may fly, the preferred first."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Timetable:
    """What each vehicle flies, and when it starts, in seconds.

    `meeting` counts the vehicles in the air for which no wait is long enough: they do not wait.
    """

    choices: dict[int, FlightChoice]
    starts_s: dict[int, int]
    meeting: int = 0

    @property
    def ends_s(self) -> dict[int, float]:
        """When each vehicle has landed."""
        return {k: self.starts_s[k] + one.track.duration_s for k, one in self.choices.items()}

    @property
    def rank(self) -> tuple[int, int, float]:
        """Value to minimise: meetings, vehicles near to unheard ones, last landing."""
        near = sum(choice.is_near for choice in self.choices.values())
        return self.meeting, near, max(self.ends_s.values(), default=0.0)


def timetable(choices: Choices, separation_m: float) -> Timetable:
    """Return a good timetable in which no two vehicles come nearer than a separation.

    Those on the ground can always wait until others have landed.
    """
    return _Search(choices, separation_m).best()


class _Search:
    def __init__(self, choices: Choices, separation_m: float) -> None:
        self._choices = choices
        self._conflicts = Conflicts(separation_m)
        preferred = {k: next(iter(own)).track for k, own in choices.items()}
        self._order = sorted(
            choices, key=lambda k: (not preferred[k].is_aloft, -preferred[k].duration_s)
        )
        # Layers, turns and directions of a vehicle's flights have one box.
        self._near: dict[int, set[int]] = {k: set() for k in choices}
        numbers = list(choices)
        for apart_m, i, j in box_distances(list(preferred.values())):
            if apart_m < separation_m:
                self._near[numbers[i]].add(numbers[j])
                self._near[numbers[j]].add(numbers[i])
        self._may_wait = not any(track.is_aloft for track in preferred.values())
        longest_s = max((track.duration_s for track in preferred.values()), default=0.0)
        self._least = (0, 0, longest_s)
        self._tries = 0
        self._most_tries = min(MOST_TRIES, MOST_TURNS // max(1, len(choices)))

    def best(self) -> Timetable:
        """Return the best timetable of some orders, each a small change of the best so far."""
        order, best = self._order, self._from_the_begin(self._order)
        if self._may_wait:
            order, best = self._better([order[::-1]], order, best)
        before = None
        while best is not before and best.rank > self._least and self._tries < self._most_tries:
            before = best
            order, best = self._better(self._orders(order, best), order, best)
        return best

    def _better(
        self, orders: Iterable[list[int]], order: list[int], best: Timetable
    ) -> tuple[list[int], Timetable]:
        """Return the first better timetable of some orders with its order, or the best so far."""
        for other in orders:
            if best.rank <= self._least or self._tries >= self._most_tries:
                break
            self._tries += 1
            found = self._from_the_begin(other)
            if found.rank < best.rank:
                return other, found
        return order, best

    def _orders(self, order: list[int], best: Timetable) -> Iterator[list[int]]:
        """Yield other orders in which to give vehicles their starts."""
        if self._may_wait:
            late = self._from_the_end(best)
            yield sorted(order, key=lambda k: late[k])
        last = max(order, key=lambda k: best.ends_s[k])
        rest = [k for k in order if k != last]
        now = order.index(last)
        for place in (*range(now - 1, -1, -1), *range(now + 1, len(order))):
            yield [*rest[:place], last, *rest[place:]]

    def _from_the_begin(self, order: Sequence[int]) -> Timetable:
        """Return the timetable in which each in turn lands as early as it can."""
        choices: dict[int, FlightChoice] = {}
        starts: dict[int, int] = {}
        meeting = 0
        for k in order:
            others = [(choices[i].track, starts[i]) for i in choices if i in self._near[k]]
            found = self._earliest(k, others)
            meeting += found is None
            choices[k], starts[k] = found or (next(iter(self._choices[k])), 0)
        return Timetable(choices=choices, starts_s=starts, meeting=meeting)

    def _earliest(
        self, vehicle: int, others: Sequence[tuple[FlightTrack, int]]
    ) -> tuple[FlightChoice, int] | None:
        """Return what a vehicle flies, and from when, to land first; None: all meet others."""
        best: tuple[bool, float, FlightChoice, int] | None = None
        for choice in self._choices[vehicle]:
            duration_s = choice.track.duration_s
            if best is not None and (choice.is_near, duration_s) >= best[:2]:
                continue
            start = next(self._starts(choice.track, others), None)
            if start is None:
                continue
            if best is None or (choice.is_near, start + duration_s) < best[:2]:
                best = (choice.is_near, start + duration_s, choice, start)
        return None if best is None else best[2:]

    def _starts(
        self, track: FlightTrack, others: Sequence[tuple[FlightTrack, int]]
    ) -> Iterator[int]:
        """Yield starts of a track clear of others, first the early ones."""
        last = max((begun + int(other.duration_s) + 2 for other, begun in others), default=0)
        if track.is_aloft:
            last = min(int(track.longest_wait_s), LONGEST_HOVER_S)
        return self._conflicts.open_starts(track, np.arange(last + 1), others)

    def _from_the_end(self, best: Timetable) -> dict[int, int]:
        """Return starts as late as can be without a later last landing, on the same flights."""
        end_s = max(best.ends_s.values())
        starts: dict[int, int] = {}
        for k in sorted(best.choices, key=lambda k: -best.ends_s[k]):
            track = best.choices[k].track
            others = [(best.choices[i].track, starts[i]) for i in starts if i in self._near[k]]
            latest = int(np.floor(end_s - track.duration_s))
            first = min((begun for _, begun in others), default=latest)
            earliest = min(first - int(track.duration_s) - 2, latest)
            late: IndexArray = np.arange(latest, earliest - 1, -1)
            starts[k] = next(self._conflicts.open_starts(track, late, others))
        return starts
