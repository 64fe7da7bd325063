# SPDX-License-Identifier: Apache-2.0
"""Train a policy that searches a gamma source, and compare it with others.

``python examples/train_source_search.py`` takes about four minutes of one core. The cross-entropy
method draws weights of a linear policy, keeps the best and draws again around them. Searches that
judge at the end are none of those trained on.
"""

import argparse
from collections.abc import Callable

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_learning.policies.policies import (
    FEATURES,
    LinearPolicy,
    Policy,
    at_random,
    information_gain,
    lawn_mower,
)
from rocsafe_learning.scores import score
from rocsafe_learning.source_search import SearchOptions

POPULATION, KEPT, SEARCHES = 24, 6, 24
TESTED = range(1_000_000, 1_000_200)


def train(options: SearchOptions, rounds: int, seed: int) -> FloatArray:
    """Return the weights of a linear policy that needs few readings."""
    generator = np.random.default_rng(seed)
    mean, spread = np.zeros(len(FEATURES)), np.ones(len(FEATURES))
    for number in range(rounds):
        drawn = mean + spread * generator.standard_normal((POPULATION, len(FEATURES)))
        seeds = range(number * SEARCHES, (number + 1) * SEARCHES)
        costs = [_readings(weights, seeds, options) for weights in drawn]
        best = drawn[np.argsort(costs)[:KEPT]]
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.05
        print(f'round {number + 1}: {np.mean(np.sort(costs)[:KEPT]):.1f} readings')
    return mean


def main() -> None:
    """Train, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--rounds', type=int, default=10, help='rounds of training')
    parser.add_argument('--seed', type=int, default=1, help='seed of the training')
    arguments = parser.parse_args()
    options = SearchOptions()
    weights = train(options, arguments.rounds, arguments.seed)
    policies: dict[str, Callable[[], Policy]] = {
        'lawn-mower': lambda: lawn_mower(options.area_m),
        'random': lambda: at_random(options.area_m, np.random.default_rng(1)),
        'information gain': lambda: information_gain(options.area_m),
        'trained': lambda: LinearPolicy(weights, options.area_m),
    }
    print(f'weights {dict(zip(FEATURES, weights.round(2).tolist(), strict=True))}')
    print(f'{"policy":18} readings  flight s  found  within 5 m')
    for name, make in policies.items():
        found = score(make, TESTED, options)
        print(
            f'{name:18} {found.readings:8.1f} {found.time_s:9.0f} {found.found_share:6.2f} '
            f'{found.near_share:11.2f}'
        )


def _readings(weights: FloatArray, seeds: range, options: SearchOptions) -> float:
    """Return the mean number of readings; searches that end far away count as all."""
    found = score(lambda: LinearPolicy(weights, options.area_m), seeds, options)
    return found.readings + options.readings * (1.0 - found.near_share)


if __name__ == '__main__':
    main()
