# SPDX-License-Identifier: Apache-2.0
"""Missions in which something fails, flown before they are flown."""

import pytest

from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.what_if import cases_of, what_if

from . import surveys


@pytest.mark.slow
def test_every_vehicle_every_pair_the_head_and_a_cut_are_tried():
    """Three vehicles: three times each, three pairs, and the rest once."""
    names = [case.name for case in cases_of(surveys.survey(3, 4))]
    assert len(names) == len(set(names)) == 1 + 9 + 3 + 2
    assert names[0] == 'nothing fails'
    assert 'rav0, rav2 at 50%' in names


@pytest.mark.all
def test_nothing_is_lost_whatever_fails():
    """And a head that searches longer, with all viewpoints free, is not much faster."""
    rows = list(what_if(surveys.survey(3, 4), RadioOptions(loss=0.1), 0, 0.1))
    assert all(row.missing == 0 for row in rows)
    assert all(row.least_m >= 10.0 - 1e-6 for row in rows)
    calm, *others = rows
    assert (calm.epochs, calm.duplicates, calm.central_s) == (0, 0, None)
    losses = [row for row in others if row.central_s is not None and ' at ' in row.name]
    assert len(losses) >= 6
    assert all(row.makespan_s < 1.5 * row.central_s for row in losses)
