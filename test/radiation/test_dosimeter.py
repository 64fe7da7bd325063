# SPDX-License-Identifier: Apache-2.0
"""Doses add up to integrals worked by hand, and levels are told once each way."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_radiation.detection.dosimeter import DOSE, DOSE_RATE, AlarmLevels, Dosimeter, Exposure

LEVELS = AlarmLevels(dose_rates_usvh=(100.0,), doses_usv=(10.0,), largest_gap_s=5.0)
S = 1_000_000_000


def exposure(time_s, rate, window_s=0.0, is_saturated=False):
    """Return a reading."""
    return Exposure(
        time_ns=round(time_s * S),
        window_s=window_s,
        dose_rate_usvh=rate,
        is_saturated=is_saturated,
    )


def test_windows_add_up():
    """Ten windows of a second at 3600 uSv/h are 10 uSv."""
    meter = Dosimeter(LEVELS)
    for second in range(1, 11):
        meter.add(exposure(second, 3600.0, window_s=1.0))
    assert meter.dose_usv == pytest.approx(10.0)
    assert meter.measured_s == pytest.approx(10.0)
    assert not meter.is_lower_limit


def test_instants_add_up_by_trapezoids():
    """From 0 to 7200 uSv/h in 2 s: 2 s at 3600 uSv/h."""
    meter = Dosimeter(LEVELS)
    for time_s, rate in ((0.0, 0.0), (1.0, 3600.0), (2.0, 7200.0)):
        meter.add(exposure(time_s, rate))
    assert meter.dose_usv == pytest.approx(2.0)


def test_a_long_gap_is_told_and_not_guessed():
    """A minute without readings: nothing is added for it, and the dose is a lower limit."""
    meter = Dosimeter(LEVELS)
    meter.add(exposure(1.0, 3600.0, window_s=1.0))
    meter.add(exposure(62.0, 3600.0, window_s=1.0))
    assert meter.dose_usv == pytest.approx(2.0)
    assert meter.unmeasured_s == pytest.approx(60.0)
    assert meter.is_lower_limit


def test_a_saturated_reading_makes_a_lower_limit():
    """The true dose rate may have been anything above."""
    meter = Dosimeter(LEVELS)
    meter.add(exposure(1.0, 3600.0, window_s=1.0, is_saturated=True))
    assert meter.is_lower_limit


@given(st.lists(st.integers(0, 20), min_size=1, max_size=40))
def test_what_comes_again_or_late_counts_once(order):
    """Whatever the order of arrival, the dose is that of the rising stamps."""
    meter, again = Dosimeter(LEVELS), Dosimeter(LEVELS)
    highest = -1
    for second in order:
        meter.add(exposure(second, 50.0))
        if second > highest:
            again.add(exposure(second, 50.0))
            highest = second
    assert meter.dose_usv == again.dose_usv


def test_a_level_is_told_when_reached_and_when_well_left():
    """Not again for each reading above it, nor for one that falls just below."""
    meter = Dosimeter(LEVELS)
    told = [
        [(a.quantity, a.is_reached) for a in meter.add(exposure(t, rate)) or ()]
        for t, rate in enumerate((50.0, 100.0, 150.0, 95.0, 100.0, 79.0, 50.0))
    ]
    assert told == [[], [(DOSE_RATE, True)], [], [], [], [(DOSE_RATE, False)], []]


def test_a_dose_is_reached_once():
    """It never falls."""
    meter = Dosimeter(LEVELS)
    told = [a for t in range(1, 30) for a in meter.add(exposure(t, 3600.0, 1.0)) or ()]
    doses = [a for a in told if a.quantity == DOSE]
    assert [(a.threshold, a.is_reached) for a in doses] == [(10.0, True)]
    assert doses[0].value == pytest.approx(10.0)


def test_known_levels_have_their_names():
    """IAEA levels by name, others by number."""
    meter = Dosimeter(AlarmLevels(dose_rates_usvh=(7.0, 100.0)))
    assert [a.name for a in meter.add(exposure(1, 200.0))] == ['7 uSv/h', 'inner cordon (IAEA)']


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'dose_rates_usvh': (0.0,)}, 'dose_rates_usvh = 0'),
        ({'doses_usv': (math.inf,)}, 'doses_usv = inf'),
        ({'largest_gap_s': -1.0}, 'largest_gap_s = -1'),
    ],
)
def test_wrong_levels_are_refused(change, message):
    """Naming value and limit."""
    with pytest.raises(ValueError, match=message):
        AlarmLevels(**change)
