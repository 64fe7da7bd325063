# SPDX-License-Identifier: Apache-2.0
"""What is photographed: places of splits, poses, placements; all from the seed alone."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from test.scene.scenes import PLANT, THINGS, small_environment

pytest.importorskip('panda3d', reason='panda3d is not installed')
from rocsafe_dataset.dataset_camera import site_of
from rocsafe_dataset.options import SPLITS, DatasetOptions
from rocsafe_dataset.poses.arrangements import arrange, bounds_of
from rocsafe_dataset.poses.ground_splits import divide_ground
from rocsafe_dataset.poses.image_poses import draw_pose, split_of
from rocsafe_scene.scene.sunlight import sun_direction

OPTIONS = DatasetOptions(count=60, seed=5)
PEOPLE = {
    'name': 'crew',
    'make': 'person',
    'scatter': {'count': 9, 'around': (0.0, -14.0), 'spread_m': (3.0, 3.0)},
}


@pytest.fixture(scope='module')
def environment():
    """Return a handful of things, a tree and a crowd."""
    return small_environment(*THINGS, PLANT, PEOPLE)


@pytest.fixture(scope='module')
def site(environment):
    """Return it as pictures are planned over it."""
    return site_of(environment, OPTIONS)


@pytest.mark.parametrize(
    ('values', 'text'),
    [
        ({'count': 0}, 'count'),
        ({'size_px': (8, 480)}, 'size_px'),
        ({'fov_deg': 170.0}, 'fov_deg is 170: must be 5 to 120'),
        ({'height_m': (30.0, 20.0)}, 'height_m is 30 to 20'),
        ({'nadir_share': 1.5}, 'nadir_share'),
        ({'image_format': 'bmp'}, "image_format is 'bmp': must be jpg or png"),
        ({'weathers': ('clear', 'snow')}, 'weathers are clear, snow'),
        ({'splits': (0.5, 0.2, 0.2)}, 'splits sum to 0.9: must be 1'),
    ],
)
def test_mistakes_are_named(values, text):
    """The option, its value, its limit."""
    with pytest.raises(ValueError, match=text):
        DatasetOptions(**{'count': 10, **values})


def test_pictures_are_split_in_the_shares_asked_for():
    """However many there are: never more than a picture or so off."""
    for count in (20, 100, 1000):
        found = Counter(split_of(number, OPTIONS) for number in range(count))
        for split, share in enumerate(OPTIONS.splits):
            assert found[split] == pytest.approx(share * count, abs=2.5)


def test_blocks_are_shared_by_what_stands_on_them():
    """Each split gets ground and things near its share; one without a share gets nothing."""
    things = np.random.default_rng(1).uniform(-90.0, 90.0, (400, 2))
    places = divide_ground((100.0, 100.0), things, (0.6, 0.2, 0.2), 3)
    shares = np.bincount(places.split_of(things), minlength=3) / len(things)
    assert shares == pytest.approx([0.6, 0.2, 0.2], abs=0.1)
    alone = divide_ground((100.0, 100.0), things, (1.0, 0.0, 0.0), 3)
    assert set(alone.split_of(things).tolist()) == {0}
    assert alone.split_of(np.array([[140.0, 0.0]])).tolist() == [-1]


@pytest.mark.slow
def test_poses_keep_to_the_ground_of_their_split(site):
    """At most a tenth of the near ground in view is another split's, wherever that can be had."""
    takes = [draw_pose(number, site, OPTIONS) for number in range(OPTIONS.count)]
    assert {chosen.split for chosen in takes} == set(SPLITS)
    foreign = np.array([chosen.foreign_share for chosen in takes])
    assert np.mean(foreign <= 0.1) > 0.9
    for chosen in takes:
        ground = site.terrain.height_at(chosen.position[None, :2])[0]
        assert 13.9 <= chosen.position[2] - ground <= 60.1
        assert chosen.rotation[2, 2] < -0.3


def test_a_pose_depends_on_the_seed_and_the_number_alone(site):
    """Not on what was drawn before."""
    first = draw_pose(7, site, OPTIONS)
    draw_pose(8, site, OPTIONS)
    again = draw_pose(7, site, OPTIONS)
    assert np.array_equal(first.position, again.position)
    assert np.array_equal(first.rotation, again.rotation)
    other = draw_pose(7, site, replace(OPTIONS, seed=6))
    assert not np.array_equal(first.position, other.position)


def test_small_things_stand_elsewhere_and_nothing_in_another(environment):
    """People move and some go; trees, houses and wrecks stay; all feet on the ground."""
    state = arrange(3, environment, OPTIONS)
    before = {thing.number: thing for thing in environment.objects}
    moved = [
        thing for thing in state.objects
        if not np.array_equal(thing.pieces[0].offset, before[thing.number].pieces[0].offset)
    ]  # fmt: skip
    assert len(moved) >= 4
    assert {thing.label for thing in moved} <= {'person', 'ambulance'}
    for thing in moved:
        low, high = bounds_of(thing)[:, :2]
        for other in state.objects:
            if other is not thing:
                lower, upper = bounds_of(other)[:, :2]
                assert not (np.all(lower < high) and np.all(upper > low)), other.name
        foot = thing.pieces[0].offset
        assert foot[2] == pytest.approx(environment.terrain.height_at(foot[None, :2])[0], abs=0.5)


def test_the_sun_is_up_in_every_arrangement(environment):
    """And the same number gives the same light and places again."""
    place = environment.description.place
    states = [arrange(number, environment, OPTIONS) for number in range(12)]
    for state in states:
        sun = sun_direction(state.time, place.latitude_deg, place.longitude_deg)
        assert sun[2] > 0.15
    assert len({state.weather for state in states}) >= 3
    again = arrange(4, environment, OPTIONS)
    assert (again.weather, again.time) == (states[4].weather, states[4].time)
    assert [thing.number for thing in again.objects] == [t.number for t in states[4].objects]
