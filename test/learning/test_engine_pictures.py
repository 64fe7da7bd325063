# SPDX-License-Identifier: Apache-2.0
"""Pictures of the engine as observations: of the place where the drone is, and nothing else."""

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from test.scene.scenes import small_environment

gymnasium = pytest.importorskip('gymnasium')
pettingzoo_test = pytest.importorskip('pettingzoo.test')
pytest.importorskip('panda3d', reason='panda3d is not installed')

from gymnasium.utils.env_checker import check_env  # noqa: E402

from rocsafe_learning.environments import engine_pictures  # noqa: E402
from rocsafe_learning.environments.engine_pictures import (  # noqa: E402
    EnginePictures,
    FleetPictures,
    PictureOptions,
)
from rocsafe_learning.environments.fleet_search_env import FleetSearchEnv  # noqa: E402
from rocsafe_learning.environments.source_search_env import SourceSearchEnv  # noqa: E402
from rocsafe_learning.environments.survey_env import SurveyEnv  # noqa: E402
from rocsafe_learning.source_search import SearchOptions  # noqa: E402
from rocsafe_learning.survey import SurveyOptions  # noqa: E402
from rocsafe_scene.engine.oversampled_camera import open_renderer  # noqa: E402

OPTIONS = PictureOptions(scene_file=Path('none.yaml'), height_m=20.0, width_px=48, height_px=32)
FOCAL_PX = 24.0 / math.tan(math.radians(30.0))


@pytest.fixture(autouse=True, scope='module')
def _scene(drawing):
    """Draw a handful of things in place of a scene of minutes."""
    environment = small_environment()
    found = open_renderer(environment, environment.description), environment.terrain
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(engine_pictures, 'scene_of', lambda _file, _seed: found)
        yield


@pytest.mark.slow
def test_the_official_checkers_have_nothing_to_say():
    """One drone and several; pictures are in the space that is told, the same for a seed."""
    with warnings.catch_warnings():
        warnings.filterwarnings('ignore', message='.*different from the unwrapped')
        check_env(EnginePictures(SurveyEnv(), OPTIONS), skip_render_check=True)
        check_env(EnginePictures(SourceSearchEnv(), OPTIONS), skip_render_check=True)
    fleet = FleetPictures(FleetSearchEnv(SearchOptions(vehicles=2, readings=5)), OPTIONS)
    pettingzoo_test.parallel_api_test(fleet, num_cycles=20)


@pytest.mark.slow
def test_the_picture_shows_the_place_of_the_drone():
    """North is up: two metres farther north, all that is seen lies four pixels farther down."""
    env = EnginePictures(SurveyEnv(SurveyOptions(area_m=100.0)), OPTIONS)
    env.reset(seed=1)
    before, after, away = (
        env.step(np.array([0.0, north], np.float32))[0]['picture'].astype(float)
        for north in (0.0, 0.04, 0.8)
    )
    assert np.abs(away - before).mean() > 5.0
    shifts = np.arange(-9, 10)
    differences = [np.abs(after[10 + k : 22 + k] - before[10:22]).mean() for k in shifts]
    assert abs(shifts[np.argmin(differences)] - 2.0 * FOCAL_PX / OPTIONS.height_m) < 1.0


@pytest.mark.slow
def test_a_search_is_the_same_with_and_without_pictures():
    """Readings and rewards do not change."""
    plain, drawn = SourceSearchEnv(), EnginePictures(SourceSearchEnv(), OPTIONS)
    for env in (plain, drawn):
        env.reset(seed=3)
    for action in np.random.default_rng(1).uniform(-1.0, 1.0, (4, 2)).astype(np.float32):
        one, two = plain.step(action), drawn.step(action)
        assert one[1:4] == two[1:4]
        assert np.array_equal(one[0]['belief'], two[0]['belief'])


@pytest.mark.parametrize(
    ('change', 'text'),
    [({'height_m': 0.5}, 'height_m'), ({'fov_deg': 180.0}, 'fov_deg'), ({'width_px': 2}, 'width')],
)
def test_a_camera_that_cannot_be_is_refused(change, text):
    """By the name of the option."""
    with pytest.raises(ValueError, match=text):
        PictureOptions(scene_file=Path('none.yaml'), **change)


def test_an_environment_without_a_place_is_refused():
    """Nothing is drawn of a drone that is nowhere."""
    with pytest.raises(ValueError, match='pose'):
        engine_pictures.with_picture(gymnasium.spaces.Discrete(3), OPTIONS)
