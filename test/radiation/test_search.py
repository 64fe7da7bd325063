# SPDX-License-Identifier: Apache-2.0
"""A search measures where it tells most, ends when that is enough, and counts nothing twice."""

import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_hazard.pending_request import PendingRequest
from rocsafe_radiation.belief.belief_grid import BeliefGrid, YesNoSensor
from rocsafe_radiation.decision.sequential_decision import SequentialEvidence, sequential_evidence
from rocsafe_radiation.decision.stopping import ABSENT, CONTINUE, PRESENT, StoppingRule
from rocsafe_radiation.decision.waypoint_choice import log_volume, next_waypoints
from rocsafe_radiation.localization.estimates import Localization, SourceEstimate
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.localize import localize
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.row_checks import dead_caveats

from .simulated_survey import LOSSLESS, survey

PAPER = Kernel(is_lossy=False)
SENSOR = YesNoSensor(false_positive=0.05, false_negative=0.1)


def places():
    """Return a grid of places at 32 m."""
    axis = np.arange(0.0, 300.1, 15.0)
    return np.array([(x, y, 32.0) for x, y in itertools.product(axis, axis)])


@pytest.mark.slow
def test_the_next_places_lie_around_the_source_not_above_it():
    """Above it, counts do not change with the place: they tell strength, not position."""
    found = localize(survey([(150.0, 150.0, 925.0)]), LOSSLESS)
    chosen = next_waypoints(found, places(), 550.0, PAPER, 6)
    distances = [math.dist(one.place_m[:2], (150.0, 150.0)) for one in chosen]
    assert max(distances) < 100.0
    assert np.median(distances) > 10.0
    assert [one.gain for one in chosen] == sorted((one.gain for one in chosen), reverse=True)


@pytest.mark.slow
def test_the_promised_gain_is_what_a_reading_brings():
    """The volume after forty readings more, against the promise, with exact fixes."""
    exact = dataclasses.replace(LOSSLESS, position_std_m=0.0, response_std=0.0)
    readings = survey([(150.0, 150.0, 925.0)])
    found = localize(readings, exact)
    chosen = next_waypoints(found, places(), 550.0, PAPER, 40)
    extra = np.array([one.place_m for one in chosen])
    squares = ((extra - [150.0, 150.0, 0.0]) ** 2).sum(axis=1)
    counts = np.random.default_rng(1).poisson(550.0 * (0.1 + 925.0 / squares)).astype(float)
    more = type(readings)(
        positions_enu_m=np.vstack([readings.positions_enu_m, extra]),
        counts=np.append(readings.counts, counts),
        exposures=np.append(readings.exposures, np.full(len(extra), 550.0)),
    )
    fell = log_volume(found) - log_volume(localize(more, exact))
    promised = sum(one.gain for one in chosen)
    # The promise counts the strength, too.
    assert 0.4 * promised < fell < 1.3 * promised


@pytest.mark.slow
def test_without_a_source_there_is_nothing_to_sharpen():
    """A search for sources goes on with its survey."""
    assert next_waypoints(localize(survey([]), LOSSLESS), places(), 550.0, PAPER, 3) == []


def test_walds_test_keeps_its_error_rates():
    """Poisson counts looked at after each: wrong in at most 2 % of 400 sequences of each kind."""
    rule = StoppingRule(false_alarm=0.02, missed=0.02)
    generator = np.random.default_rng(5)
    for truth, wrong in ((4.0, PRESENT), (6.0, ABSENT)):
        mistakes = 0
        for _ in range(400):
            ratio, verdict = 0.0, CONTINUE
            while verdict == CONTINUE:
                ratio += generator.poisson(truth) * math.log(6.0 / 4.0) - 2.0
                verdict = rule.decision(
                    SequentialEvidence(log_ratio=ratio, log_ratio_smallest=ratio)
                )
            mistakes += verdict == wrong
        assert mistakes <= 14, 'three standard deviations above 2 %'


def test_a_source_is_decided_for_and_its_absence_against():
    """1 GBq of caesium (92 uSv/h at 1 m) is strong enough to tell, 0.01 GBq is not."""
    rule = StoppingRule()
    setting = Setting(kernel=PAPER)
    for strength, smallest, decided in (
        (300.0, 92.0, PRESENT),
        (0.0, 92.0, ABSENT),
        (0.0, 1.0, CONTINUE),
    ):
        sources = [(150.0, 150.0, strength)] if strength else []
        evidence = sequential_evidence(survey(sources, seed=4), setting, smallest)
        assert rule.decision(evidence) == decided


def test_a_source_is_not_excluded_where_nobody_looked():
    """Half of the ground seen, half of the doubt left, and the doubt is where it was not seen."""
    whole = survey([], seed=2)
    west = whole.positions_enu_m[:, 0] < 150.0
    # The corners say how far the ground reaches.
    west |= np.hypot(*(whole.positions_enu_m[:, :2] - 300.0).T) < 1.0
    half = type(whole)(
        positions_enu_m=whole.positions_enu_m[west],
        counts=whole.counts[west],
        exposures=whole.exposures[west],
    )
    evidence = sequential_evidence(half, Setting(kernel=PAPER), 92.0)
    assert StoppingRule().decision(evidence) == CONTINUE
    doubtful = evidence.places_m[np.argsort(evidence.doubts)[-20:]]
    assert doubtful[:, 0].min() > 150.0


def test_a_survey_is_enough_when_number_and_place_are_sure():
    """Not with a wide ellipse, nor with a rival order."""

    def found(axis_m, chances):
        covariance = np.diag([axis_m**2, axis_m**2, 0.0, 0.01]) / 5.991
        source = SourceEstimate(
            position_enu_m=np.zeros(3),
            dose_rate_at_1m_usvh=1.0,
            joint_covariance=covariance,
            detection_llr=50.0,
        )
        return Localization(
            sources=(source,),
            order_probabilities=chances,
            background_usvh=0.1,
            background_std_usvh=0.0,
            reading_count=99,
            dispersion=0.0,
            rho=0.0,
            is_structured=False,
        )

    rule = StoppingRule(ellipse_95_m=5.0)
    evidence = SequentialEvidence(log_ratio=50.0, log_ratio_smallest=50.0)
    assert rule.verdict(found(4.0, (0.0, 1.0)), evidence).is_enough
    wide = rule.verdict(found(6.0, (0.0, 1.0)), evidence)
    assert (wide.is_enough, wide.reason) == (
        False,
        '1 source, placed within 6.0 m (95 %): 5 m are wanted',
    )
    assert not rule.verdict(found(4.0, (0.0, 0.9, 0.1)), evidence).is_enough
    unread = dataclasses.replace(found(4.0, (0.0, 1.0)), caveats=dead_caveats(9))
    assert rule.verdict(unread, evidence).reason.startswith('9 readings are of a dead detector')
    with pytest.raises(ValueError, match='false_alarm = 0'):
        StoppingRule(false_alarm=0.0)


def test_a_cell_is_believed_by_bayes_rule():
    """One yes: 0.1 * 0.9 / (0.1 * 0.9 + 0.9 * 0.05)."""
    grid = BeliefGrid(np.full((2, 2), 0.1), 'rav1')
    grid.observe(SENSOR, (0, 1), True)
    assert grid.probabilities()[0, 1] == pytest.approx(0.09 / 0.135)
    assert grid.probabilities()[1, 1] == pytest.approx(0.1)


@pytest.mark.slow
@given(
    answers=st.lists(
        st.tuples(st.sampled_from('ab'), st.integers(0, 2), st.booleans()), max_size=25
    ),
    meetings=st.lists(st.sampled_from(['ab', 'ba']), max_size=6),
)
def test_agents_agree_whatever_their_meetings(answers, meetings):
    """Merged in any order, as often as they like, both believe what one agent would."""
    grids = {name: BeliefGrid(np.full((1, 3), 0.2), name) for name in 'ab'}
    alone = BeliefGrid(np.full((1, 3), 0.2), 'c')
    for agent, column, is_yes in answers:
        grids[agent].observe(SENSOR, (0, column), is_yes)
        alone.observe(SENSOR, (0, column), is_yes)
    for first, second in [*meetings, 'ab', 'ba']:
        grids[first].merge(grids[second])
    for grid in grids.values():
        assert grid.probabilities() == pytest.approx(alone.probabilities())


def test_a_sensor_that_always_lies_is_refused():
    """Naming the rate."""
    with pytest.raises(ValueError, match='false_negative = 0'):
        YesNoSensor(false_positive=0.1, false_negative=0.7)


def test_a_question_waits_for_readings_that_still_come():
    """For a quiet moment and for what came until then; after three askings it waits no longer."""
    inquiry = PendingRequest()
    second = 1_000_000_000
    inquiry.news(0)
    assert not inquiry.is_answerable(second // 2, 10, 10), 'more may come'
    assert not inquiry.is_answerable(second, 12, 10), 'two are not evaluated'
    inquiry.news(second)
    assert inquiry.is_answerable(second, 14, 12), 'what there was when it was asked'
    asked = [inquiry.is_answerable(second, 20, 20) for _ in range(3)]
    assert asked == [False, False, True]


def test_ground_not_seen_yet_hides_no_source_that_was_seen():
    """Half of the ground read, the other known but unread: what was seen counts as it is."""
    whole = survey([(75.0, 150.0, 92.0)], seed=3)
    unread = whole.positions_enu_m[:, 0] > 150.0
    half = type(whole)(
        positions_enu_m=whole.positions_enu_m,
        counts=np.where(unread, 0.0, whole.counts),
        exposures=np.where(unread, 1e-6, whole.exposures),
    )
    evidence = sequential_evidence(half, Setting(kernel=PAPER), 92.0)
    assert StoppingRule().decision(evidence) == PRESENT
    assert evidence.log_ratio_smallest > 10.0
