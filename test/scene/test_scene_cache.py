# SPDX-License-Identifier: Apache-2.0
"""Built scenes kept between runs: read where they fit, made anew where they do not."""

import numpy as np
import pytest
from test.scene.scenes import THINGS, describe, plain_map

from rocsafe_geo.position import GeoPosition
from rocsafe_scene.graphics.memory import drop_mapped_pages
from rocsafe_scene.ground.ground_map import GroundMap
from rocsafe_scene.scene import map_cache, scene_cache

ORIGIN = GeoPosition(53.28, -9.06, 60.0)


class Maker:
    """Counts how often it is asked."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self):
        """Return a few numbers."""
        self.count += 1
        return np.arange(5.0), self.count


def test_a_scene_is_made_once(tmp_path):
    """The second time it is read, equal to the last bit."""
    maker = Maker()
    first = scene_cache.kept(maker, describe(*THINGS), 1, ORIGIN, tmp_path)
    again = scene_cache.kept(maker, describe(*THINGS), 1, ORIGIN, tmp_path)
    assert maker.count == 1
    assert np.array_equal(first[0], again[0])


@pytest.mark.parametrize('change', ['description', 'seed', 'origin', 'damage', 'source'])
def test_a_scene_is_made_anew_where_anything_differs(tmp_path, monkeypatch, change):
    """What it is made from, the code that makes it, or a damaged file."""
    maker = Maker()
    scene_cache.kept(maker, describe(*THINGS), 1, ORIGIN, tmp_path)
    description = describe(*THINGS[:2]) if change == 'description' else describe(*THINGS)
    origin = GeoPosition(53.0, -9.0, 60.0) if change == 'origin' else ORIGIN
    if change == 'damage':
        (path,) = tmp_path.glob('*.pickle')
        path.write_bytes(path.read_bytes()[:40])
    if change == 'source':
        monkeypatch.setattr(scene_cache, 'source_digest', lambda: 'other')
    scene_cache.kept(maker, description, 2 if change == 'seed' else 1, origin, tmp_path)
    assert maker.count == 2


def test_a_mesh_file_that_changed_is_read_again(tmp_path):
    """By its size and time of change."""
    mesh = tmp_path / 'wagon.obj'
    mesh.write_text('v 0 0 0')
    maker = Maker()
    entry = {'name': 'wagon', 'mesh': str(mesh), 'at': (0.0, 0.0)}
    scene_cache.kept(maker, describe(entry), 1, ORIGIN, tmp_path / 'cache')
    mesh.write_text('v 0 0 0 1')
    scene_cache.kept(maker, describe(entry), 1, ORIGIN, tmp_path / 'cache')
    assert maker.count == 2


def test_old_scenes_are_forgotten_and_a_full_disk_is_no_failure(tmp_path):
    """The newest stay; where nothing can be written, the scene is made all the same."""
    maker = Maker()
    for seed in range(scene_cache._MOST + 3):
        scene_cache.kept(maker, describe(), seed, ORIGIN, tmp_path)
    assert len(list(tmp_path.glob('*.pickle'))) == scene_cache._MOST
    (tmp_path / 'file').write_text('')
    scene_cache.kept(maker, describe(), 1, ORIGIN, tmp_path / 'file')
    assert maker.count == scene_cache._MOST + 4


def test_painted_ground_is_kept_in_a_file_that_processes_share(tmp_path):
    """What is read is what was painted, mapped from the file; forgotten, it is read again."""
    painted = []

    def paint() -> GroundMap:
        painted.append(plain_map((8.0, 8.0)))
        return painted[-1]

    first, again = (map_cache._kept(tmp_path / 'ground.npz', paint) for _ in range(2))
    assert len(painted) == 1
    for ground in (first, again):
        assert isinstance(ground.colours, np.memmap)
        drop_mapped_pages(ground.colours)
        assert np.array_equal(ground.colours, painted[0].colours)
        assert np.array_equal(ground.classes, painted[0].classes)
