# SPDX-License-Identifier: Apache-2.0
"""The report's section on agents: contact, epochs, plans made anew, duplicates."""

from typing import Any

from rocsafe_orchestrator.products.run_record import AgentSample
from rocsafe_orchestrator.report.sections.fleet_view import fleet_view
from rocsafe_view import formats

ALL = ('rav1', 'rav2', 'rav3')
BEGIN_NS = 100_000_000_000


def sample(time_s: float, vehicle: str, **changes: Any) -> AgentSample:
    """Return a sample of an agent that hears all others."""
    values: dict[str, Any] = {
        'epoch': 0, 'coordinator': '', 'heard': ALL, 'members': ALL, 'unable': (),
        'duplicates': 0, 'bytes_sent': 0, 'alarms': 0, **changes,
    }  # fmt: skip
    return AgentSample(time_ns=BEGIN_NS + int(time_s * 1e9), vehicle=vehicle, **values)


def test_mission_without_agents_has_no_section() -> None:
    """Nothing is shown."""
    assert fleet_view((), BEGIN_NS) is None


def test_contact_is_the_part_of_the_time_that_others_were_heard() -> None:
    """Each by itself: a radio may carry one way only."""
    view = fleet_view(
        (
            sample(1.0, 'rav1'), sample(2.0, 'rav1', heard=('rav1', 'rav3')),
            sample(1.0, 'rav2'), sample(2.0, 'rav2'), sample(1.0, 'rav3', heard=('rav3',)),
        ),
        BEGIN_NS,
    )  # fmt: skip
    assert view is not None
    assert view.vehicles == ALL
    half, whole, none = (formats.percent(share, 0) for share in (0.5, 1.0, 0.0))
    assert view.contact_rows == (
        ('rav1', '', half, whole),
        ('rav2', whole, '', whole),
        ('rav3', none, none, ''),
    )


def test_rounds_of_the_search_are_told_once() -> None:
    """With who chose them and why; the last has no places."""
    first = {
        'search_round': 1, 'search_by': 'rav1', 'search_places': 4, 'search_text': 'too wide',
    }  # fmt: skip
    last = {'search_round': 2, 'search_by': 'rav2', 'search_text': 'enough'}
    view = fleet_view(
        (sample(1.0, 'rav1'), sample(40.0, 'rav1', **first), sample(41.0, 'rav2', **first),
         sample(90.0, 'rav2', **last), sample(91.0, 'rav1', **last)),
        BEGIN_NS,
    )  # fmt: skip
    assert view is not None
    assert view.round_rows == (
        ('1', '00:40', 'rav1', '4', 'too wide'),
        ('2', '01:30', 'rav2', 'none: the search is over', 'enough'),
    )


def test_each_epoch_of_each_part_of_the_fleet_is_told_once() -> None:
    """Two parts may have made plans with the same number; duplicates and alarms are counted."""
    left = {'epoch': 1, 'coordinator': 'rav1', 'members': ('rav1', 'rav2'), 'unable': ('rav3',)}
    right = {'epoch': 1, 'coordinator': 'rav3', 'members': ('rav3',)}
    both = {'epoch': 2, 'coordinator': 'rav1', 'duplicates': 4, 'alarms': 1, 'bytes_sent': 900}
    view = fleet_view(
        (
            sample(0.0, 'rav1'), sample(30.0, 'rav1', **left), sample(31.0, 'rav2', **left),
            sample(32.0, 'rav3', **right), sample(95.0, 'rav1', **both),
        ),
        BEGIN_NS,
    )  # fmt: skip
    assert view is not None
    assert view.epoch_rows == (
        ('1', '00:30', 'rav1', 'rav1, rav2', 'rav3'),
        ('1', '00:32', 'rav3', 'rav3', 'none'),
        ('2', '01:35', 'rav1', 'rav1, rav2, rav3', 'none'),
    )
    assert view.agent_rows[0] == ('rav1', '2', '2', '900', '1')
    assert view.sentence == (
        '3 agents, 3 plans made anew, 4 photographs taken twice, 1 epoch with plans that differ.'
    )
