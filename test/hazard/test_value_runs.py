# SPDX-License-Identifier: Apache-2.0
"""Values that stand still: logged too often, stuck, or at the end of the detector's scale."""

import numpy as np
import pytest

from rocsafe_hazard.value_runs import are_again, are_at_top, are_computed


def noisy(seed=0, count=90):
    """Return readings of clean air with fine steps, and some of a plume."""
    generator = np.random.default_rng(seed)
    plume = np.where(generator.random(count) < 0.2, generator.gamma(2.0, 5.0, count), 0.0)
    return generator.normal(0.0, 1.0, count) + plume


def test_values_read_five_times_are_one():
    """A logger that is faster than its detector."""
    again = are_again(np.repeat(noisy(), 5))
    assert again.sum() == 4 * 90
    assert not again[::5].any()


def test_a_stuck_detector_counts_once():
    """From the moment on from which it shows one value."""
    values = noisy()
    values[40:] = 0.0
    assert are_again(values).nonzero()[0].tolist() == list(range(41, 90))


def test_computed_readings_may_be_alike():
    """Where a vehicle stands, as those of the default mission, which were told as stuck."""
    passed = 9000.0 / ((np.linspace(-60.0, 60.0, 90)) ** 2 + 400.0)
    standing = np.concatenate([np.full(20, passed[0]), passed])
    assert are_computed(standing)
    assert not are_again(standing).any()
    noise = np.random.default_rng(1).normal(1.0, 0.01, 90)
    assert not are_computed(passed * noise)
    assert are_again(np.repeat(passed * noise, 2)).sum() == 90


@pytest.mark.parametrize('seed', range(10))
def test_readings_of_a_vehicle_that_stands_are_judged_where_it_moves(seed):
    """Computed ones, also where it turns so sharply that they are not smooth; none of a logger."""
    generator = np.random.default_rng(seed)
    steps_m = np.where(np.arange(120) < 60, 0.0, 8.0) + np.abs(generator.normal(0.0, 0.02, 120))
    flown = np.exp(generator.normal(0.0, 0.3, 60))
    values = np.concatenate([np.full(60, 1.3), flown])
    assert are_again(values).sum() == 59
    assert not are_again(values, steps_m).any()
    read_twice = np.concatenate([np.full(60, 1.3), np.repeat(flown[:30], 2)])
    assert are_again(read_twice, steps_m).sum() == 89


@pytest.mark.parametrize('seed', range(20))
def test_coarse_steps_and_zeros_of_clean_air_repeat_themselves(seed):
    """Equal neighbours tell nothing there."""
    assert not are_again(np.round(noisy(seed))).any()
    assert not are_again(np.maximum(noisy(seed), 0.0)).any()
    assert not are_again(noisy(seed)).any()
    assert not are_again(np.insert(noisy(seed), [20, 50], noisy(seed)[[19, 49]])).any()
    assert not are_again(np.repeat([0.1, 0.2, 0.3], 50)).any()


@pytest.mark.parametrize('seed', range(20))
def test_only_what_piles_up_is_the_end_of_a_scale(seed):
    """A plume that is cut off, negative values that are not shown; not the largest of many."""
    values = noisy(seed)
    cut = np.minimum(values, 5.0)
    assert (are_at_top(cut) == (cut == 5.0)).all() or (cut == 5.0).sum() < 4
    lowest = np.maximum(values, 0.0)
    assert (are_at_top(-lowest) == (lowest == 0.0)).all()
    counts = np.random.default_rng(seed).poisson(100.0, 5000).astype(float)
    for none in (values, counts, np.round(counts / 550.0, 2), np.repeat(values, 5)):
        assert not are_at_top(none).any()


@pytest.mark.parametrize('values', [[], [1.0], [2.0, 2.0, 2.0]])
def test_few_values_have_no_scale(values):
    """Nothing is known of their steps."""
    assert not are_at_top(np.array(values)).any()
    assert not are_again(np.array(values)).any()
