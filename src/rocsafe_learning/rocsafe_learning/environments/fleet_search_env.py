# SPDX-License-Identifier: Apache-2.0
"""Several drones search one source and share what they read."""

from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium.utils import seeding
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from rocsafe_learning.environments.search_spaces import (
    Observation,
    action_space,
    observation_space,
    observe,
    target_m,
    truth_of,
)
from rocsafe_learning.source_search import SearchOptions, SourceSearch

Dicts = dict[str, Any]


class FleetSearchEnv(ParallelEnv[str, Observation, NDArray[np.float32]]):
    """Every drone flies to a place of its own and reads; all have the same belief and reward.

    A step takes as long as the longest flight of it.

    Parameters
    ----------
    options
        What is searched; default: a gamma source on 100 m x 100 m by three drones.
    """

    metadata: ClassVar[dict[str, Any]] = {'name': 'rocsafe_fleet_search_v0', 'render_modes': []}

    def __init__(self, options: SearchOptions | None = None) -> None:
        self.search = SourceSearch(options or SearchOptions(vehicles=3))
        names = [f'rav{number}' for number in range(1, self.search.options.vehicles + 1)]
        self.possible_agents = names
        self.agents: list[str] = []
        self.render_mode = None
        # The same objects at every call, as PettingZoo asks.
        self._actions = {name: action_space() for name in names}
        self._observations = {name: observation_space(self.search.options) for name in names}
        self._generator = np.random.default_rng(0)

    @property
    def area_m(self) -> float:
        """Side of the square area, metres."""
        return self.search.options.area_m

    def observation_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return the space of what a drone knows."""
        return self._observations[agent]

    def action_space(self, agent: str) -> gymnasium.Space[Any]:
        """Return the space of the places that a drone may choose."""
        return self._actions[agent]

    def reset(
        self,
        seed: int | None = None,
        options: Dicts | None = None,  # noqa: ARG002
    ) -> tuple[Dicts, Dicts]:
        """Draw a source and begin; `options` is of PettingZoo and not used."""
        if seed is not None:
            self._generator, _ = seeding.np_random(seed)
        self.agents = list(self.possible_agents)
        self.search.begin(self._generator)
        return self._all_observations(), {name: truth_of(self.search) for name in self.agents}

    def step(
        self, actions: dict[str, NDArray[np.float32]]
    ) -> tuple[Dicts, dict[str, float], dict[str, bool], dict[str, bool], Dicts]:
        """Fly to the places that `actions` name, one of each drone, and read."""
        if not self.agents:
            return {}, {}, {}, {}, {}
        if missing := [name for name in self.possible_agents if name not in actions]:
            raise ValueError(f'actions: that of {missing[0]} is missing')
        area = self.search.options.area_m
        places = [target_m(np.asarray(actions[name]), area) for name in self.possible_agents]
        done = self.search.advance(places, self._generator)
        is_cut = self.search.is_over and not done.is_found
        names = self.agents
        found = self._all_observations()
        truth = truth_of(self.search)
        if done.is_found or is_cut:
            self.agents = []
        return (
            found,
            dict.fromkeys(names, done.reward),
            dict.fromkeys(names, done.is_found),
            dict.fromkeys(names, is_cut),
            {name: dict(truth) for name in names},
        )

    def _all_observations(self) -> Dicts:
        return {
            name: observe(self.search, index) for index, name in enumerate(self.possible_agents)
        }
