# SPDX-License-Identifier: Apache-2.0
"""Places of a further round: the answers of all who look for sources, as one."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Generic, TypeVar

PlaceT = TypeVar('PlaceT')


@dataclass(frozen=True, slots=True, kw_only=True)
class Search:
    """How often one of them may ask for a further round, and for how many places each."""

    extra_rounds: int
    viewpoints_a_round: int


class Advice(Generic[PlaceT]):
    """Asks in each round those that have rounds left, and joins their answers.

    Parameters
    ----------
    searches
        The search of each adviser, by the name of its service.
    """

    def __init__(self, searches: Mapping[str, Search]) -> None:
        self._searches = dict(searches)
        self._rounds = 0
        self._answers: dict[str, tuple[list[PlaceT], str]] = {}

    @property
    def open_questions(self) -> Iterator[tuple[str, int]]:
        """Yield the name of each adviser that has not answered, and the places wanted."""
        for name in self._asked():
            if name not in self._answers:
                yield name, self._searches[name].viewpoints_a_round

    def add(self, name: str, places: list[PlaceT], reason: str) -> tuple[list[PlaceT], str] | None:
        """Take an answer; return all places and reasons once nobody is left to answer."""
        if name not in self._asked():
            return None
        self._answers[name] = (places, reason)
        asked = self._asked()
        if len(self._answers) < len(asked):
            return None
        answers = [self._answers[name] for name in asked]
        self._rounds, self._answers = self._rounds + 1, {}
        reasons = '; '.join(reason for _, reason in answers if reason)
        return [place for places, _ in answers for place in places], reasons

    def _asked(self) -> list[str]:
        return [
            name for name, search in self._searches.items() if search.extra_rounds > self._rounds
        ]
