# SPDX-License-Identifier: Apache-2.0
"""Sun and fog of a scene that are changed while it is watched."""

import math
from datetime import datetime, timezone
from pathlib import Path

import numpy as np
import pytest
from test.scene.scenes import small_environment

pytest.importorskip('panda3d', reason='panda3d is not installed')

from rocsafe_geo.pinhole import PinholeCamera, rotation_body_from_optical, rotation_enu_from_body
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.cameras import engine_camera
from rocsafe_scene.cameras.engine_camera import EngineCamera, EngineRequest, EngineScene
from rocsafe_scene.scene.moving_sun import LightOrder, MovingSun
from rocsafe_scene.scene.sunlight import WEATHERS, Air

START_NS = int(datetime(2025, 6, 1, 11, tzinfo=timezone.utc).timestamp()) * NS_PER_S
LENS = PinholeCamera(1.0, 96, 72)
LOOK = np.asarray(rotation_enu_from_body(0.3, 0.0, 0.0) @ rotation_body_from_optical(0.35, 0.0))
PLACE = (-40.0, -20.0, 30.0)


def test_fog_and_wetness_are_added_to_the_weather() -> None:
    """None leaves it as it is, to the last bit; all of it is that of the weather fog."""
    for weather in WEATHERS.values():
        assert Air().added_to(weather) == weather
    assert Air(fog=1.0).added_to(WEATHERS['clear']) == WEATHERS['fog']
    half = Air(fog=0.5, wetness=0.8).added_to(WEATHERS['clear'])
    assert half.haze_per_m == pytest.approx((0.00022 + 0.011) / 2)
    assert half.wetness == 0.8
    with pytest.raises(ValueError, match=r'fog is 1\.5'):
        Air(fog=1.5)


def test_the_sun_moves_by_steps_of_time() -> None:
    """60 times as fast as time, each 10 s; before its begin it stands."""
    sun = MovingSun(sun_ns=1000 * NS_PER_S, from_ns=50 * NS_PER_S, speed=60.0, step_s=10.0)
    at_s = [sun.at(second * NS_PER_S) / NS_PER_S for second in (0, 50, 59, 60, 85)]
    assert at_s == [1000.0, 1000.0, 1000.0, 1600.0, 2800.0]
    with pytest.raises(ValueError, match='sun_speed is -1'):
        MovingSun(sun_ns=0, from_ns=0, speed=-1.0)


def opened(monkeypatch) -> EngineScene:
    """Return a small scene."""
    environment = small_environment()
    monkeypatch.setattr(engine_camera, 'read_scene', lambda _: environment.description)
    monkeypatch.setattr(engine_camera, 'build', lambda *_: environment)
    origin = GeoPosition(53.28, -9.06, 60.0)
    request = EngineRequest(
        scene_file=Path(), seed=1, origin=origin, start_ns=START_NS, cache=None
    )
    return EngineScene(request)


@pytest.mark.slow
def test_a_narrower_lens_shows_the_middle_larger(drawing, monkeypatch) -> None:
    """Depths are those of the wide lens at the same ray; the first camera draws as before."""
    camera = EngineCamera(opened(monkeypatch), LENS, 2)
    first = camera.photograph(PLACE, LOOK, START_NS)
    wide = camera.truth.depth_m
    # Each pixel of half the tangent is half as wide.
    narrow_rad = 2.0 * math.atan(0.5 * math.tan(0.5 * LENS.horizontal_fov_rad))
    narrow = camera.through(PinholeCamera(narrow_rad, LENS.image_width_px, LENS.image_height_px))
    narrow.photograph(PLACE, LOOK, START_NS, is_quick=True)
    height, width = wide.shape
    middle = wide[height // 4 : height - height // 4, width // 4 : width - width // 4]
    halved = narrow.truth.depth_m.reshape(height // 2, 2, width // 2, 2).mean(axis=(1, 3))
    with np.errstate(invalid='ignore'):
        same = np.isclose(halved, middle, rtol=0.05)
    assert same.mean() > 0.9
    assert np.array_equal(camera.photograph(PLACE, LOOK, START_NS), first)
    # A script that zooms fills no memory with buffers.
    windows = camera._scene.renderer.pipe.engine.getNumWindows()
    for px in (40, 50, 60):
        zoomed = camera.through(
            PinholeCamera(px / 48.0, LENS.image_width_px, LENS.image_height_px)
        )
        zoomed.photograph(PLACE, LOOK, START_NS, is_quick=True)
    assert camera._scene.renderer.pipe.engine.getNumWindows() == windows


@pytest.mark.slow
def test_the_light_of_a_scene_changes_and_comes_back(drawing, monkeypatch) -> None:
    """Fog hides what is far, the sun moves the shadows, and the first light draws the same."""
    camera = EngineCamera(opened(monkeypatch), LENS, 1)

    def seen(order: LightOrder, seconds: int = 5):
        camera.set_light(order)
        return camera.photograph(PLACE, LOOK, START_NS + seconds * NS_PER_S).astype(int)

    first = seen(LightOrder())
    foggy = seen(LightOrder(air=Air(fog=1.0)))
    far = np.asarray(camera.truth.depth_m) > 60.0
    assert far.any()
    assert foggy[far].std() < 0.6 * first[far].std()
    evening = MovingSun(sun_ns=START_NS + 8 * 3600 * NS_PER_S, from_ns=START_NS)
    assert np.abs(seen(LightOrder(sun=evening)) - first).mean() > 5.0
    assert np.array_equal(seen(LightOrder()), first)
