# SPDX-License-Identifier: Apache-2.0
"""Names under which gymnasium makes the environments."""

import gymnasium

SOURCE_SEARCH, SURVEY = 'rocsafe/SourceSearch-v0', 'rocsafe/Survey-v0'


def register_environments() -> None:
    """Register all environments that have one agent."""
    for name, entry in (
        (SOURCE_SEARCH, 'source_search_env:SourceSearchEnv'),
        (SURVEY, 'survey_env:SurveyEnv'),
    ):
        if name not in gymnasium.registry:
            gymnasium.register(id=name, entry_point=f'rocsafe_learning.environments.{entry}')
