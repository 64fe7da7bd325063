# SPDX-License-Identifier: Apache-2.0
"""Charts keep peaks, and their times are round."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_view.charts import DOSE_BOTTOM, DOSE_TOP, FlightBar, TimeAxis, dose_lines, time_axes
from rocsafe_view.map_marks import DosePoint
from rocsafe_view.palette import DoseScale

SCALE = DoseScale(low_usvh=1.0, high_usvh=100.0)


def places(path):
    """Return the points of path data."""
    return [tuple(map(float, step.split())) for step in path.lstrip('M').split('L')]


@given(st.floats(1.0, 1e5))
def test_ticks_are_round_and_not_crowded(end_s):
    """At most one tick in 79 pixels unless the axis is longer than a day."""
    axis = TimeAxis(width=1080, left=70, end_s=end_s)
    ticks = axis.ticks()
    assert ticks[0] == 0.0
    assert ticks[-1] <= end_s
    if len(ticks) > 1 and end_s < 86_400.0:
        assert axis.x(ticks[1]) - axis.x(ticks[0]) >= 79.0


def test_axis_reaches_to_the_end_of_the_longest_plan():
    """A flight that was cut short still shows what was planned."""
    flights = [FlightBar(vehicle='rav1', start_s=10.0, end_s=100.0, planned_s=200.0,
                         aloft_s=((10.0, 100.0),), shots_s=())]  # fmt: skip
    assert {axis.end_s for axis in time_axes(flights).values()} == {210.0}


def test_long_series_keeps_its_peak():
    """Of 10,000 readings at most about 500 are drawn, the highest one among them."""
    points = [DosePoint(0.0, 0.0, 0.1 * i, 100.0 if i == 7777 else 1.0, 'rav1')
              for i in range(10_000)]  # fmt: skip
    axis = TimeAxis(width=1080, left=70, end_s=1000.0)
    drawn = places(dose_lines(points, SCALE, ['rav1'], axis)['rav1'])
    assert len(drawn) <= 502
    assert min(y for _, y in drawn) == DOSE_TOP
    assert (round(axis.x(777.7), 1), DOSE_TOP) in drawn


def test_half_of_the_decades_is_half_of_the_height():
    """10 lies half-way between 1 and 100."""
    axis = TimeAxis(width=1080, left=70, end_s=10.0)
    lines = dose_lines([DosePoint(0.0, 0.0, 5.0, 10.0, 'rav1')], SCALE, ['rav1', 'rav2'], axis)
    assert places(lines['rav1']) == [(568.0, pytest.approx((DOSE_TOP + DOSE_BOTTOM) / 2))]
    assert lines['rav2'] == ''


def test_no_line_leads_beyond_its_axis():
    """Detectors read on after the last landing."""
    axis = TimeAxis(width=1080, left=70, end_s=10.0)
    points = [DosePoint(0.0, 0.0, 2.0 * i, 10.0, 'rav1') for i in range(10)]
    drawn = places(dose_lines(points, SCALE, ['rav1'], axis)['rav1'])
    assert max(x for x, _ in drawn) == axis.right
