# SPDX-License-Identifier: Apache-2.0
"""Measure the environments for learning: steps per second of one core.

``python benchmarks/learning.py`` prints a line for each environment. Actions are random; episodes
begin anew when they end. A step of a search is a flight to a place, one reading and the update of
the belief of 32 x 32 cells.
"""

import argparse
import time
from typing import Any

import numpy as np

from rocsafe_learning.environments.fleet_search_env import FleetSearchEnv
from rocsafe_learning.environments.source_search_env import SourceSearchEnv
from rocsafe_learning.environments.survey_env import SurveyEnv
from rocsafe_learning.sensing.gas_sensor_model import PlumeSensor
from rocsafe_learning.source_search import SearchOptions


def one_agent(env: Any, steps: int) -> float:
    """Return the steps per CPU-second of an environment of Gymnasium."""
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (steps, 2)).astype(np.float32)
    env.reset(seed=1)
    began_s = time.process_time()
    for action in actions:
        _, _, found, over, _ = env.step(action)
        if found or over:
            env.reset()
    return steps / (time.process_time() - began_s)


def several_agents(env: FleetSearchEnv, steps: int) -> float:
    """Return the steps of all agents per CPU-second."""
    names = env.possible_agents
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (steps, len(names), 2))
    rows = actions.astype(np.float32)
    env.reset(seed=1)
    began_s = time.process_time()
    for row in rows:
        env.step(dict(zip(names, row, strict=True)))
        if not env.agents:
            env.reset()
    return steps * len(names) / (time.process_time() - began_s)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--steps', type=int, default=20_000, help='steps of each environment')
    steps = parser.parse_args().steps
    gas = SearchOptions(sensor=PlumeSensor())
    print(f'SourceSearchEnv, gamma  {one_agent(SourceSearchEnv(), steps):8.0f} steps/s')
    print(f'SourceSearchEnv, gas    {one_agent(SourceSearchEnv(gas), steps):8.0f} steps/s')
    print(f'SurveyEnv               {one_agent(SurveyEnv(), steps):8.0f} steps/s')
    print(f'FleetSearchEnv, 3       {several_agents(FleetSearchEnv(), steps):8.0f} agent-steps/s')


if __name__ == '__main__':
    main()
