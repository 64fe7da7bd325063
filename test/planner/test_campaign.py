# SPDX-License-Identifier: Apache-2.0
"""Some of the surveys of `tools/planning_campaign.py`: no fault in what becomes of them."""

import pytest

from drawn_surveys import drawn_request
from planning_campaign import Tally, look


@pytest.mark.slow
@pytest.mark.parametrize('number', [5, 14])
def test_drawn_surveys_are_planned_or_refused(number):
    """Each is planned, changed, planned anew, or refused in a line; the checker agrees."""
    tally = Tally()
    look(number, tally)
    assert tally.faults == []
    assert tally.plans + sum(tally.refusals.values()) > 0


def test_a_number_draws_the_same_survey_again():
    """So that a fault can be looked into."""
    assert drawn_request(3).identity() == drawn_request(3).identity()
