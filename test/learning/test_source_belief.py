# SPDX-License-Identifier: Apache-2.0
"""A belief about one source: Bayes' rule, and what it says about itself."""

import numpy as np
import pytest

from rocsafe_learning.sensing.gamma_sensor import GammaSensor
from rocsafe_learning.sensing.gas_sensor_model import PlumeSensor
from rocsafe_learning.source_belief import PARTS, BeliefTables, SourceBelief
from rocsafe_learning.source_search import SearchOptions, SourceSearch

SENSOR = GammaSensor()


def test_posterior_is_that_of_bayes():
    """Of few readings, by direct computation: likelihood averaged over places within a cell."""
    tables = BeliefTables.of(SENSOR, area_m=40.0, cells=4, strengths=2)
    belief = SourceBelief(tables)
    readings = [((2.5, 10.0), 20.0), ((37.5, 5.0), 9.0), ((40.0, 40.0), 8.0)]
    logs = np.zeros((2, 4, 4))
    inner = (np.arange(PARTS) + 0.5) / PARTS
    shares = (np.arange(6) + 0.5) / 6.0
    for place, value in readings:
        belief.add(place, value)
        for level in range(2):
            for row in range(4):
                for column in range(4):
                    east, north = np.meshgrid(10.0 * (column + inner), 10.0 * (row + inner))
                    offsets = np.stack([place[0] - east, place[1] - north], axis=-1)
                    pairs = [
                        SENSOR.expected(offsets, strength)
                        for strength in SENSOR.strengths(shares[3 * level : 3 * level + 3])
                    ]
                    mean = np.mean([one for one, _ in pairs])
                    square = np.mean([one**2 + spread for one, spread in pairs])
                    spread = square - mean**2
                    logs[level, row, column] -= 0.5 * (
                        (value - mean) ** 2 / spread + np.log(spread)
                    )
    expected = np.exp(logs - logs.max())
    expected /= expected.sum()
    assert np.moveaxis(belief.joint, 2, 0) == pytest.approx(expected, abs=2e-5)
    assert belief.cells == pytest.approx(expected.sum(axis=0), abs=2e-5)
    entropy = -float((expected * np.log(np.maximum(expected, 1e-300))).sum())
    assert belief.entropy_nats == pytest.approx(entropy, abs=1e-3)


def test_gains_add_up_to_the_fall_of_the_entropy():
    """From that of equal probabilities."""
    belief = SourceBelief(BeliefTables.of(SENSOR, area_m=100.0))
    start = belief.entropy_nats
    assert start == pytest.approx(np.log(10 * 32 * 32))
    gains = [belief.add((25.0 * n, 50.0), 5.0 + n) for n in range(4)]
    assert sum(gains) == pytest.approx(start - belief.entropy_nats, abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize('sensor', [GammaSensor(), PlumeSensor()], ids=['gamma', 'gas'])
def test_it_is_as_sure_as_it_is_right(sensor):
    """Over searches the squared error is the squared spread that it states, within a third."""
    search = SourceSearch(SearchOptions(sensor=sensor))
    ratios = []
    for seed in range(80):
        generator = np.random.default_rng(seed)
        search.begin(generator)
        for _ in range(15):
            place = tuple(generator.uniform(0.0, 100.0, 2).tolist())
            search.advance([place], generator)
        ratios.append(search.error_m() / search.belief.mean_and_spread_m()[1])
    assert 0.67 <= np.sqrt(np.mean(np.square(ratios))) <= 1.33


@pytest.mark.slow
def test_a_place_is_rounded_by_at_most_half_a_step():
    """And the whole area can be reached."""
    tables = BeliefTables.of(SENSOR, area_m=100.0)
    for value in np.linspace(0.0, 100.0, 57):
        assert abs(tables.rounded_m((value, 0.0))[0] - value) <= tables.step_m / 2.0 + 1e-9
    belief = SourceBelief(tables)
    for corner in ((0.0, 0.0), (100.0, 0.0), (0.0, 100.0), (100.0, 100.0)):
        belief.add(corner, 5.0)
    assert np.isfinite(belief.entropy_nats)


@pytest.mark.slow
def test_readings_beyond_all_that_is_expected_leave_probabilities():
    """No division by zero: the sum stays 1."""
    belief = SourceBelief(BeliefTables.of(SENSOR, area_m=100.0))
    for value in (1e6, -1e6, 1e6):
        belief.add((50.0, 50.0), value)
        assert float(belief.cells.sum()) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        ({'detector': 'nose'}, "detector = 'nose' must be one of"),
        ({'height_m': 0.0}, 'height_m is 0'),
        ({'strongest_usvh': 1.0}, 'strongest_usvh = 1 must be within weakest_usvh = 5'),
    ],
)
def test_bad_values_are_named(changes, words):
    """Before anything flies."""
    with pytest.raises(ValueError, match=words):
        GammaSensor(**changes)
