# SPDX-License-Identifier: Apache-2.0
"""Who holds up simulated time, and who is left out of it."""

from rocsafe_orchestrator.mission_state.step_reports import LATE_S, StepReports

NAMES = ('rav1', 'rav2')


def test_nobody_is_late_for_a_step_that_is_new() -> None:
    """The first report of a step makes it the newest: the others have had no time for it."""
    steps = StepReports()
    steps.done('rav1', 100, 10.0)
    assert steps.late(NAMES, 10.0) == ()
    assert steps.late(NAMES, 10.0 + LATE_S) == ('rav2',)
    steps.done('rav2', 100, 12.0)
    assert steps.late(NAMES, 12.0) == ('world',)
    steps.done('rav2', 200, 12.1)
    assert steps.late(NAMES, 12.2) == ()
    assert steps.late(NAMES, 12.1 + LATE_S) == ('rav1',)


def test_who_is_left_out_is_so_until_it_is_heard_again() -> None:
    """Its earlier messages do not count."""
    steps = StepReports()
    assert not steps.is_left_out('rav1', 0.0)
    steps.left_out('rav1', 20.0)
    assert steps.is_left_out('rav1', 19.0)
    assert not steps.is_left_out('rav1', 20.5)
    assert not steps.is_left_out('rav2', 19.0)
