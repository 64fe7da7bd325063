# SPDX-License-Identifier: Apache-2.0
"""One drone photographs an area."""

from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from rocsafe_learning.environments.search_spaces import Observation, action_space, target_m
from rocsafe_learning.survey import CELLS, Survey, SurveyOptions


class SurveyEnv(gymnasium.Env[Observation, NDArray[np.float32]]):
    """Fly to a place, take a photograph, and so on until the area is seen.

    Observation: ``pose`` own place and ``home``, -1 to 1; ``time_left`` 0 to 1; ``seen`` 1 for
    cells that a photograph shows. The home is drawn on the western edge.

    Parameters
    ----------
    options
        What is photographed; default: 100 m x 100 m.
    """

    metadata: ClassVar[dict[str, Any]] = {'render_modes': []}

    def __init__(self, options: SurveyOptions | None = None) -> None:
        self.survey = Survey(options or SurveyOptions())
        self.action_space = action_space()
        self.observation_space = spaces.Dict(
            {
                'pose': spaces.Box(-1.0, 1.0, (2,), np.float32),
                'home': spaces.Box(-1.0, 1.0, (2,), np.float32),
                'time_left': spaces.Box(0.0, 1.0, (1,), np.float32),
                'seen': spaces.Box(0.0, 1.0, (CELLS, CELLS), np.float32),
            }
        )

    @property
    def area_m(self) -> float:
        """Side of the square area, metres."""
        return self.survey.options.area_m

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002
    ) -> tuple[Observation, dict[str, Any]]:
        """Draw a home and begin; `options` is of gymnasium and not used."""
        super().reset(seed=seed)
        self.survey.begin((0.0, float(self.np_random.uniform(0.0, self.survey.options.area_m))))
        return self._observe(), self._info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Fly to the place that `action` names and photograph."""
        reward = self.survey.advance(target_m(np.asarray(action), self.survey.options.area_m))
        is_complete = self.survey.is_complete
        is_cut = self.survey.is_over and not is_complete
        return self._observe(), reward, is_complete, is_cut, self._info()

    def _observe(self) -> Observation:
        survey, side = self.survey, self.survey.options.area_m
        left = 1.0 - survey.time_s / survey.options.endurance_s
        return {
            'pose': np.array(survey.place_m, np.float32) * np.float32(2.0 / side) - 1.0,
            'home': np.array(survey.home_m, np.float32) * np.float32(2.0 / side) - 1.0,
            'time_left': np.array([min(max(left, 0.0), 1.0)], np.float32),
            'seen': survey.seen_share(),
        }

    def _info(self) -> dict[str, Any]:
        return {'seen_share': float(self.survey.seen.mean()), 'time_s': self.survey.time_s}
