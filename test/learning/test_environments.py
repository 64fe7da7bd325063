# SPDX-License-Identifier: Apache-2.0
"""Environments pass the official checks, repeat themselves, and reward what they say."""

import math
import subprocess
import sys
import warnings
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip('gymnasium')
pettingzoo_test = pytest.importorskip('pettingzoo.test')

from gymnasium.utils.env_checker import check_env  # noqa: E402

from rocsafe_learning.environments.fleet_search_env import FleetSearchEnv  # noqa: E402
from rocsafe_learning.environments.source_search_env import SourceSearchEnv  # noqa: E402
from rocsafe_learning.environments.survey_env import SurveyEnv  # noqa: E402
from rocsafe_learning.registration import (  # noqa: E402
    SOURCE_SEARCH,
    SURVEY,
    register_environments,
)
from rocsafe_learning.sensing.gas_sensor_model import PlumeSensor  # noqa: E402
from rocsafe_learning.source_search import SearchOptions  # noqa: E402
from rocsafe_learning.survey import SurveyOptions  # noqa: E402

ROLL = """
import numpy as np
from rocsafe_learning.environments.source_search_env import SourceSearchEnv
env = SourceSearchEnv()
env.reset(seed=7)
actions = np.random.default_rng(3).uniform(-1.0, 1.0, (12, 2)).astype(np.float32)
rows = [env.step(action) for action in actions]
print([(row[0]['reading'].tolist(), row[4]['source_m']) for row in rows])
"""


@pytest.mark.parametrize('name', [SOURCE_SEARCH, SURVEY])
def test_gymnasium_has_nothing_to_say(name):
    """Its checker finds no fault, under the registered name."""
    register_environments()
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        warnings.filterwarnings('ignore', message='.*[Mm]ore than one|.*render')
        check_env(gymnasium.make(name).unwrapped, skip_render_check=True)


def test_the_lines_of_the_page_run_in_a_process_of_their_own():
    """What a newcomer copies first from docs/learning.md, and nothing that a test did before."""
    page = (Path(__file__).parents[2] / 'docs' / 'learning.md').read_text()
    blocks = page.split('\n\n#')[0].split('\n\n')
    lines = [line[4:] for block in blocks for line in block.splitlines() if line[:4] == '    ']
    code = '\n'.join(line for line in lines if not line.startswith('pip '))
    assert 'gymnasium.make' in code
    subprocess.run([sys.executable, '-c', code], check=True, timeout=60.0)


def test_gymnasium_has_nothing_to_say_about_gas():
    """The same with a plume."""
    check_env(SourceSearchEnv(SearchOptions(sensor=PlumeSensor())), skip_render_check=True)


def test_pettingzoo_has_nothing_to_say():
    """Its tests of the interface and of seeds pass."""
    pettingzoo_test.parallel_api_test(FleetSearchEnv(), num_cycles=200)
    pettingzoo_test.parallel_seed_test(FleetSearchEnv, num_cycles=20)


def test_same_seed_is_the_same_search_in_every_process():
    """Readings and source, to the last digit."""
    said = {
        subprocess.run(
            [sys.executable, '-c', ROLL], check=True, capture_output=True, text=True
        ).stdout
        for _ in range(2)
    }
    assert len(said) == 1


def test_a_search_ends_when_its_readings_are_taken():
    """Cut off, not found: the drone stays in a corner far from the source."""
    env = SourceSearchEnv(SearchOptions(readings=3, placed_m=0.01))
    env.reset(seed=1)
    ends = [env.step(np.array([-1.0, -1.0], np.float32))[2:4] for _ in range(3)]
    assert ends == [(False, False), (False, False), (False, True)]


def test_reward_is_what_it_is_said_to_be():
    """Information won less time, and something for finding."""
    options = SearchOptions(reward_per_nat=2.0, reward_per_s=-0.5, reward_found=0.0)
    env = SourceSearchEnv(options)
    env.reset(seed=4)
    before, time_s = env.search.belief.entropy_nats, env.search.time_s
    _, reward, *_ = env.step(np.array([0.3, -0.2], np.float32))
    won = before - env.search.belief.entropy_nats
    assert reward == pytest.approx(2.0 * won - 0.5 * (env.search.time_s - time_s), abs=1e-6)


def test_members_of_a_fleet_know_each_others_places():
    """In the order of their names, without themselves."""
    env = FleetSearchEnv()
    env.reset(seed=1)
    places = {'rav1': [-1.0, 0.0], 'rav2': [0.0, 1.0], 'rav3': [0.5, 0.5]}
    found, *_ = env.step({name: np.array(place, np.float32) for name, place in places.items()})
    assert found['rav2']['peers'].tolist() == [places['rav1'], places['rav3']]


def test_survey_is_complete_when_all_is_seen():
    """Along lanes narrower than a photograph; the share seen only grows."""
    env = SurveyEnv(SurveyOptions(endurance_s=1000.0))
    env.reset(seed=1)
    shares, is_complete = [0.0], False
    for north in np.linspace(-0.9, 0.9, 7):
        for east in np.linspace(-0.9, 0.9, 6):
            _, _, is_complete, _, info = env.step(np.array([east, north], np.float32))
            shares.append(info['seen_share'])
    assert is_complete
    assert (np.diff(shares) >= 0.0).all()


def test_drone_that_surveys_gets_home():
    """It flies home where the battery would not do for one photograph more."""
    env = SurveyEnv(SurveyOptions(endurance_s=30.0))
    env.reset(seed=1)
    is_cut = False
    while not is_cut:
        action = env.action_space.sample()
        _, _, _, is_cut, info = env.step(action)
    assert env.survey.place_m == env.survey.home_m
    assert info['time_s'] <= 30.0


@pytest.mark.parametrize(
    ('action', 'words'),
    [
        ([math.nan, 0.0], 'action is nan, 0.0: must be two numbers'),
        ([0.0], r'action has shape \(1,\)'),
        ([[0.0, 0.0]], r'action has shape \(1, 2\)'),
    ],
)
def test_an_action_that_is_none_is_named(action, words):
    """Of a policy that has diverged, or of another environment."""
    for env in (SourceSearchEnv(), SurveyEnv()):
        env.reset(seed=1)
        with pytest.raises(ValueError, match=words):
            env.step(np.array(action, np.float32))
    fleet = FleetSearchEnv()
    fleet.reset(seed=1)
    with pytest.raises(ValueError, match='actions: that of rav1 is missing'):
        fleet.step({})
