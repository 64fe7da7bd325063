# SPDX-License-Identifier: Apache-2.0
"""Search a source by random flights: the loop of Gymnasium, to put an agent of your own into.

python examples/gymnasium_loop.py
"""

import gymnasium

from rocsafe_learning.registration import register_environments


def main(seed: int = 1) -> float:
    """Fly one search and return its reward."""
    register_environments()
    environment = gymnasium.make('rocsafe/SourceSearch-v0')
    environment.action_space.seed(seed)
    environment.reset(seed=seed)
    total, is_over, readings = 0.0, False, 0
    while not is_over:
        action = environment.action_space.sample()  # your agent decides here
        _, reward, is_found, is_cut_off, _ = environment.step(action)
        total += float(reward)
        is_over, readings = is_found or is_cut_off, readings + 1
    print(f'{readings} readings, reward {total:.2f}')
    return total


if __name__ == '__main__':
    main()
