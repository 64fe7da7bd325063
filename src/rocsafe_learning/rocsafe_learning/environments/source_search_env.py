# SPDX-License-Identifier: Apache-2.0
"""One drone searches one source."""

from typing import Any, ClassVar

import gymnasium
import numpy as np
from numpy.typing import NDArray

from rocsafe_learning.environments.search_spaces import (
    Observation,
    action_space,
    observation_space,
    observe,
    target_m,
    truth_of,
)
from rocsafe_learning.source_search import SearchOptions, SourceSearch


class SourceSearchEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """Fly to a place, take a reading there, and so on until the source is found.

    An episode ends (``terminated``) when the belief is narrow enough, and is cut off
    (``truncated``) when all readings are taken. ``info`` has the truth, which no policy may use.

    Parameters
    ----------
    options
        What is searched; default: a gamma source on 100 m x 100 m.

    Examples
    --------
    >>> env = SourceSearchEnv()
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, found, over, info = env.step(env.action_space.sample())
    >>> observation['belief'].shape
    (32, 32)
    """

    metadata: ClassVar[dict[str, Any]] = {'render_modes': []}

    def __init__(self, options: SearchOptions | None = None) -> None:
        self.search = SourceSearch(options or SearchOptions())
        if self.search.options.vehicles != 1:
            raise ValueError(
                f'vehicles = {self.search.options.vehicles} must be 1; FleetSearchEnv has several'
            )
        self.action_space = action_space()
        self.observation_space = observation_space(self.search.options)

    @property
    def area_m(self) -> float:
        """Side of the square area, metres."""
        return self.search.options.area_m

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002
    ) -> tuple[Observation, dict[str, Any]]:
        """Draw a source and begin; `options` is of gymnasium and not used."""
        super().reset(seed=seed)
        self.search.begin(self.np_random)
        return observe(self.search, 0), truth_of(self.search)

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Fly to the place that `action` names and read."""
        place = target_m(np.asarray(action), self.search.options.area_m)
        done = self.search.advance([place], self.np_random)
        is_cut = self.search.is_over and not done.is_found
        return observe(self.search, 0), done.reward, done.is_found, is_cut, truth_of(self.search)
