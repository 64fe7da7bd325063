# SPDX-License-Identifier: Apache-2.0
"""Answers of all that look for sources become one: where to fly next."""

from rocsafe_orchestrator.mission.advice import Advice, Search


def search(rounds: int, count: int = 3) -> Search:
    """Return a search of so many rounds."""
    return Search(extra_rounds=rounds, viewpoints_a_round=count)


def test_places_of_all_are_flown_to_once_all_have_answered() -> None:
    """Whoever answers first waits for the others; an answer that comes again changes nothing."""
    advice: Advice[str] = Advice({'gamma': search(1, 2), 'gas': search(1, 5)})
    assert dict(advice.open_questions) == {'gamma': 2, 'gas': 5}
    assert advice.add('gas', ['c'], 'wide') is None
    assert dict(advice.open_questions) == {'gamma': 2}
    assert advice.add('gamma', ['a', 'b'], 'far') == (['a', 'b', 'c'], 'far; wide')
    assert advice.add('gamma', ['a'], 'late') is None


def test_only_those_with_rounds_left_are_asked() -> None:
    """Each has its own number of rounds, one without any is never asked."""
    advice: Advice[str] = Advice({'gamma': search(0), 'gas': search(2), 'other': search(1)})
    assert [name for name, _ in advice.open_questions] == ['gas', 'other']
    advice.add('gas', [], '')
    assert advice.add('other', [], 'enough') == ([], 'enough')
    assert [name for name, _ in advice.open_questions] == ['gas']
    assert advice.add('other', ['a'], 'late') is None
    assert advice.add('gas', ['a'], 'more') == (['a'], 'more')
    assert list(advice.open_questions) == []
