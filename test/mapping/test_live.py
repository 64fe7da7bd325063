# SPDX-License-Identifier: Apache-2.0
"""The map while photographs come in."""

import importlib.util
import math
import pathlib
import time

import cv2
import numpy as np
import pytest

from rocsafe_mapping.errors import MappingError, PlacementError
from rocsafe_mapping.live.live_map import LiveMap
from rocsafe_mapping.mosaic.mapmaker import MapOptions

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)


@pytest.fixture
def live(tmp_path):
    """An empty map with tiles."""
    live = LiveMap(MapOptions(ground_resolution_m=0.2), tmp_path / 'tiles', pytest.fail)
    yield live
    live.close()


def receive(live, shot):
    """Let a photograph land."""
    live.receive(shot.record, lambda: shot.jpeg)


def covered(live):
    """Return how many pixels the preview shows."""
    picture = cv2.imdecode(np.frombuffer(live.preview.png(), np.uint8), cv2.IMREAD_UNCHANGED)
    return int(np.count_nonzero(picture[..., 3]))


def test_a_photograph_is_shown_before_anything_is_computed(live):
    """As soon as it is received, where its fix says."""
    shots = texture.flight(1)
    receive(live, shots[0])
    first = covered(live)
    receive(live, shots[5])
    assert covered(live) > 1.5 * first > 0
    assert live.by_features == 0


def test_a_photograph_is_refined_by_its_own_piece_of_work(live):
    """Tied to a neighbour and moved with it, without waiting for the rest."""
    shots = texture.flight(1)
    receive(live, shots[0])
    receive(live, shots[1])
    assert live.work()
    assert live.work()
    assert live.by_features == 2


@pytest.mark.slow
def test_work_comes_to_an_end(live):
    """When all is tied, drawn and adjusted there is nothing left to do."""
    for shot in texture.flight(1):
        receive(live, shot)
    live.release_tiles()
    end = time.monotonic() + 20.0
    while live.work() or live.is_busy:
        assert time.monotonic() < end
    assert live.by_features == 6


@pytest.mark.slow
def test_tiles_show_the_map_at_all_zooms(live, tmp_path):
    """Each zoom shows the same ground in about a quarter of the pixels."""
    for shot in texture.flight(1):
        receive(live, shot)
    live.release_tiles()
    while live.work() or live.is_busy:
        pass
    seen = {}
    for path in (tmp_path / 'tiles').rglob('*.png'):
        tile = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        zoom = int(path.relative_to(tmp_path / 'tiles').parts[0])
        seen[zoom] = seen.get(zoom, 0) + np.count_nonzero(tile[..., 3] > 127)
    finest = max(seen)
    assert math.log2(40_075_017 * math.cos(math.radians(53.28)) / 256 / 0.2) == pytest.approx(
        finest, abs=0.5
    )
    assert seen[finest - 1] == pytest.approx(seen[finest] / 4, rel=0.05)
    assert seen[finest - 2] == pytest.approx(seen[finest] / 16, rel=0.1)
    assert not list((tmp_path / 'tiles').rglob('*.part'))


def test_tiles_are_drawn_once_for_all_photographs_of_a_round(live, tmp_path):
    """Not before they are released, then all that is out of date, and nothing twice."""
    for shot in texture.flight(1)[:2]:
        receive(live, shot)
    while live.work() or live.is_busy:
        pass
    assert live.has_stale_tiles
    assert not (tmp_path / 'tiles').exists()
    live.release_tiles()
    assert not live.has_stale_tiles
    rounds = 0
    while live.work():
        rounds += 1
    assert rounds == len(list((tmp_path / 'tiles').rglob('*.png')))


def test_a_photograph_without_a_fix_or_pixels_leaves_no_trace(live):
    """It is refused, and the map is as before."""
    shot = texture.flight(1)[0]
    with pytest.raises(MappingError):
        live.receive(shot.record, lambda: b'no image')
    with pytest.raises(PlacementError):
        live.receive(
            texture.record_of(1, np.array([0.0, 0.0, -1.0]), shot.rotation, 1.0, 0.1, b'', 'rav1'),
            lambda: shot.jpeg,
        )
    assert len(live) == 0
    assert not live.work()
