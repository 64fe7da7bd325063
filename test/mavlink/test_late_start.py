# SPDX-License-Identifier: Apache-2.0
"""A delay does not count again after a restart of the bridge."""

from rocsafe_mavlink.flight.late_start import LateStart


def test_restarted_bridge_keeps_the_time_of_the_start(tmp_path):
    """The same route of the same mission; when it is over it is due at once."""
    path = tmp_path / 'rav1' / 'late_start.json'
    assert LateStart(path).due_s('a', 100.0, 30.0) == 130.0
    assert LateStart(path).due_s('a', 110.0, 30.0) == 130.0
    assert LateStart(path).due_s('a', 150.0, 30.0) == 150.0


def test_another_route_counts_its_own_delay(tmp_path):
    """Also one of another mission, which has another lease."""
    kept = LateStart(tmp_path / 'late_start.json')
    kept.due_s('a', 100.0, 30.0)
    assert kept.due_s('b', 110.0, 30.0) == 140.0
    assert LateStart(tmp_path / 'late_start.json').due_s('a', 120.0, 30.0) == 150.0


def test_withdrawn_start_counts_anew(tmp_path):
    """The vehicle was told to stay, and gets the route again later."""
    kept = LateStart(tmp_path / 'late_start.json')
    kept.due_s('a', 100.0, 30.0)
    kept.forget()
    assert LateStart(tmp_path / 'late_start.json').due_s('a', 120.0, 30.0) == 150.0


def test_time_of_an_earlier_start_of_the_machine_counts_for_nothing(tmp_path):
    """Its clock begins again."""
    path = tmp_path / 'late_start.json'
    LateStart(path).due_s('a', 9000.0, 30.0)
    assert LateStart(path).due_s('a', 60.0, 30.0) == 90.0


def test_damaged_file_counts_for_nothing(tmp_path):
    """Nothing is guessed from it."""
    path = tmp_path / 'late_start.json'
    for content in ('', '[]', '{"key": "a"}', '{"key": "a", "due_s": "soon"}'):
        path.write_text(content)
        assert LateStart(path).due_s('a', 60.0, 30.0) == 90.0


def test_without_a_file_it_is_kept_in_memory():
    """As tests and `preflight` have it."""
    kept = LateStart()
    assert kept.due_s('a', 100.0, 30.0) == kept.due_s('a', 110.0, 30.0) == 130.0
