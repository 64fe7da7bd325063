# SPDX-License-Identifier: Apache-2.0
"""A mission over a source that is too strong: vehicles turn back at the limit, and say so."""

import csv
from collections.abc import Callable
from pathlib import Path

import pytest

from .conftest import Flight

pytestmark = pytest.mark.system

SCENARIO = Path(__file__).with_name('turn_back.yaml')


@pytest.mark.all
def test_vehicles_turn_back_at_the_limit(fly: Callable[..., Flight]) -> None:
    """Each comes home by the way of least dose; what nobody can photograph fails the mission."""
    flight = fly('--speed', '12')
    assert flight.end() == 1, flight.output
    for name in ('rav1', 'rav2'):
        assert f'{name}: turns back at' in flight.output
        assert f'{name}: returns by the way of least dose' in flight.output
    assert 'the limit is 200 uSv/h' in flight.info()['outcome_text']
    assert 'still in the air' not in flight.info()['outcome_text']
    with (flight.run.path / 'readings.csv').open() as file:
        rates = [float(row['dose_rate_usvh']) for row in csv.DictReader(file)]
    assert 200.0 <= max(rates) < 400.0
    assert flight.living() == []
