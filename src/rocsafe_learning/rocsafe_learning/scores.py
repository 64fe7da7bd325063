# SPDX-License-Identifier: Apache-2.0
"""How policies compare on the same searches."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rocsafe_learning.policies.policies import Policy
from rocsafe_learning.source_search import SearchOptions, SourceSearch

NEAR_M = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Means over searches.

    Attributes
    ----------
    readings
        Readings until the source was found; those of a search that did not find it count as all
        that it was allowed.
    time_s
        Time of flight, seconds.
    found_share
        Share of searches that found it.
    near_share
        Share of searches whose mean place is within 5 m of the true one at the end.
    reward
        Sum of rewards.
    """

    readings: float
    time_s: float
    found_share: float
    near_share: float
    reward: float


def score(make_policy: Callable[[], Policy], seeds: range, options: SearchOptions) -> Score:
    """Return the score of a policy, made anew for each search.

    Parameters
    ----------
    make_policy
        Makes the policy at the start of a search.
    seeds
        Seed of each search.
    options
        What is searched, by one drone.
    """
    search = SourceSearch(options)
    rows = [_fly(search, make_policy(), np.random.default_rng(seed)) for seed in seeds]
    readings, times, found, near, rewards = np.mean(rows, axis=0).tolist()
    return Score(
        readings=readings, time_s=times, found_share=found, near_share=near, reward=rewards
    )


def _fly(
    search: SourceSearch, policy: Policy, generator: np.random.Generator
) -> tuple[float, float, float, float, float]:
    search.begin(generator)
    reward, is_found = 0.0, False
    while not (is_found or search.is_over):
        done = search.advance([policy(search)], generator)
        is_found = done.is_found
        reward += done.reward
    near = search.error_m() <= NEAR_M
    return float(search.count), search.time_s, float(is_found), float(near), reward
